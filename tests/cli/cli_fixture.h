/// \file
/// The real program in a folder of its own, with a small task: the example arm, three of its poses, a short protocol.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "support/files.h"
#include "support/process.h"

namespace simgap::test {

using Arguments = std::vector<std::string>;

/// The paper's settings for a (2, 8)-ES over few generations, poses that count as steady after 0.1 s.
inline std::string quickConfig(int generations = 6) {
  std::string text = readText(sourceFile("configs/calibrate_arm.yaml"));
  for (const auto& [from, to] :
       std::map<std::string, std::string>{{"mu: 6", "mu: 2"},
                                          {"lambda: 36", "lambda: 8"},
                                          {"steady_s: 0.5", "steady_s: 0.1"},
                                          {"max_velocity_rad_s: 0.02", "max_velocity_rad_s: 0.2"},
                                          {"settle_s: 5", "settle_s: 2"},
                                          {"optimizer: lm", "optimizer: es"}}) {
    text = replaced(text, from, to);
  }
  return replaced(text, "generations: 250", "generations: " + std::to_string(generations));
}

/// Sentences of a printed result without the breaks that hold them within 80 columns.
inline std::string unwrapped(const std::string& text) { return std::regex_replace(text, std::regex("\n  +"), " "); }

/// A file of the sample robot.
inline std::string robotFile(const std::string& name) { return sourceFile("data/robot/" + name).string(); }

class CliTest : public testing::Test {
 protected:
  CliTest() {
    put("arm.yaml", readText(sourceFile("data/arm/arm.yaml")));
    put("poses.csv", firstLines(readText(sourceFile("data/arm/poses_calibration.csv")), 4));
    put("config.yaml", quickConfig());
    put("others.csv", posesOfSample(3, 3));
  }

  /// Poses of the sample arm, `count` of them from the `first` on.
  static std::string posesOfSample(std::size_t first, std::size_t count) {
    const std::string all = readText(sourceFile("data/arm/poses_calibration.csv"));
    const std::string header = firstLines(all, 1);
    return header + firstLines(all, 1 + first + count).substr(firstLines(all, 1 + first).size());
  }

  void put(const std::string& name, std::string_view text) const { folder_.put(name, text); }
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  std::string text(const std::string& name) const { return readText(path(name)); }

  static Arguments command(const Arguments& arguments) {
    Arguments all{SIMGAP_BINARY};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return all;
  }
  ProcessResult simgap(const Arguments& arguments) const { return runProcess(command(arguments), folder_.path()); }

  /// Runs what must succeed. \returns its standard output
  std::string succeed(const Arguments& arguments) const {
    const ProcessResult result = simgap(arguments);
    EXPECT_EQ(result.exit_code, 0) << testing::PrintToString(arguments) << "\n" << result.err;
    return result.out;
  }
  /// `calibrate` on the small task into `directory`.
  Arguments calibrate(const std::string& directory, const Arguments& more = {}) const {
    Arguments all{"calibrate", "arm.yaml", "--poses", "poses.csv", "--config", "config.yaml", "-q", "-o", directory};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  /// What `diagnose` answers on log.csv, in the folder d.
  Json diagnosis(const std::string& model, const Arguments& more = {}) const {
    Arguments all{"diagnose", model, "--log", "log.csv", "-q", "--force", "-o", "d"};
    all.insert(all.end(), more.begin(), more.end());
    succeed(all);
    return Json::parse(text("d/result.json"));
  }

  /// Expects an exit code and one line on stderr that holds `sentence`, nothing on stdout and nothing written.
  void expectRefused(const Arguments& arguments, int exit_code, const std::string& sentence) const {
    const auto before = everything();
    const ProcessResult result = simgap(arguments);
    SCOPED_TRACE(testing::PrintToString(arguments));
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, testing::StartsWith("simgap: "));
    EXPECT_THAT(result.err, testing::HasSubstr(sentence));
    EXPECT_EQ(countOf(result.err, "\n"), 1u) << result.err;
    EXPECT_EQ(result.err.back(), '\n');
    EXPECT_EQ(everything(), before);
  }

  /// All files below the folder with their contents.
  std::map<std::string, std::string> everything() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path())) {
      files[entry.path().string()] = entry.is_regular_file() ? readText(entry.path()) : "a folder";
    }
    return files;
  }

  /// What a calibration found, as one text: every result file but for the time it took.
  std::string found(const std::string& directory) const {
    std::string all;
    for (const char* name : {"model.yaml", "history.csv", "errors.csv", "parameters.csv", "result.json"}) {
      all += text(directory + "/" + name);
    }
    const std::size_t wall = all.find("  \"wall_s\"");
    return wall == std::string::npos ? "no wall_s" : all.erase(wall, all.find('\n', wall) - wall);
  }

  TemporaryFolder folder_;
};

}  // namespace simgap::test
