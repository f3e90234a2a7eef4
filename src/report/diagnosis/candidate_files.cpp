#include "simgap/report/diagnosis/candidate_files.h"

#include <fmt/format.h>

#include <cctype>

#include "candidate_entries.h"
#include "simgap/core/csv.h"
#include "simgap/core/error.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {
std::string candidateFileName(std::size_t number, const std::string& causes) {
  std::string name = fmt::format("{:02}-", number);
  for (const char c : causes) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
    if (plain || name.back() != '_') name += plain ? c : '_';
  }
  return name.substr(0, 60) + ".yaml";
}

std::string fileNameOf(const YamlNode& node) {
  std::string name = node.text();
  if (name.find('/') != std::string::npos) node.fail("expected a file beside this one");
  return name;
}

void requireCandidates(const std::filesystem::path& run) {
  if (std::filesystem::is_directory(run / kCandidateFolder)) return;
  throw ConfigError(
      fmt::format("{}: found no folder {}, expected the result of simgap diagnose that had models to compare: where "
                  "nothing was found there are none",
                  run.string(), kCandidateFolder));
}

bool holdsCandidates(const std::filesystem::path& run, std::string_view format) {
  const std::filesystem::path list = run / kCandidateFolder / kCandidateList;
  return std::filesystem::exists(list) && readFile(list).starts_with(fmt::format("format: {}", format));
}

void writeCandidates(const PoseDiagnosis& result, const ArmModel& given, std::span<const std::string> poses_csv,
                     const RunDirectory& directory) {
  const auto write = [&](const std::string& name, const std::string& content) {
    directory.write(fmt::format("{}/{}", kCandidateFolder, name), content);
  };
  std::string list = fmt::format("format: simgap/candidates/1\nexcess: {}\nused: [", result.excess);
  for (std::size_t p = 0; p < result.used.size(); ++p) list += (p > 0 ? ", " : "") + yamlText(result.used[p]);
  list += "]\nposes: [";
  for (std::size_t i = 0; i < poses_csv.size(); ++i) {
    const std::string file = i == 0 ? kGivenPoses : fmt::format("poses_{}.csv", i + 1);
    write(file, poses_csv[i]);
    list += (i > 0 ? ", " : "") + file;
  }
  list += "]\ncandidates:\n";
  for (std::size_t c = 0; c < result.candidates.size(); ++c) {
    const CandidateModel& candidate = result.candidates[c];
    const std::string file = candidateFileName(c, candidate.causes);
    write(file, writeArm(candidate.model));
    list += fmt::format("  - {{file: {}, causes: {}, role: {}, log_odds: {}, stray_friction: {}}}\n", file,
                        yamlText(candidate.causes), candidate.role, candidate.log_odds, candidate.stray_friction);
  }
  write(kGivenModel, writeArm(given));
  write(kCandidateList, list);
}

CandidateList CandidateList::read(const YamlNode& root) {
  root.at("format").oneOf({"simgap/candidates/1"});
  CandidateList list;
  list.excess = root.at("excess").number(Range{-1.0, 1e6, false, "a number in [-1, 1e6]"});
  for (const YamlNode& pose : root.at("used").items()) list.used.push_back(pose.text());
  for (const YamlNode& file : root.at("poses").items()) list.poses.push_back(fileNameOf(file));
  list.entries =
      readCandidateEntries<Entry>(root.at("candidates"), [](const YamlNode& node, CandidateModel& candidate) {
        candidate.log_odds = node.at("log_odds").number();
        candidate.stray_friction = node.at("stray_friction").number(kNonNegative);
      });
  root.expectAllRead();
  return list;
}

}  // namespace simgap
