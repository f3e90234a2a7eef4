// What a run promises when the machine, the user or another run gets in its way (docs/reliability.md).
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>

#include <chrono>
#include <thread>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"
#include "support/motions.h"
#include "support/sanitized.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class ReliabilityTest : public CliTest {
 protected:
  Arguments validate(const Arguments& more = {}) const {
    Arguments all{"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "out"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// The program as a shell runs it behind `prefix`, with `suffix` behind its arguments.
  ProcessResult shell(const std::string& prefix, const Arguments& arguments, const std::string& suffix = "") const {
    std::string line = prefix;
    for (const std::string& word : command(arguments)) line += " '" + word + "'";
    return runProcess({"/bin/sh", "-c", line + " " + suffix}, folder_.path());
  }
  std::string status(const std::string& directory = "out") const {
    return Json::parse(text(directory + "/run.json")).at("status");
  }
  /// Starts, waits until `ready`, sends SIGTERM once. \returns how it ended; fails when that takes over half a minute
  template <class Ready>
  ProcessResult interrupted(const Arguments& arguments, const Ready& ready) const {
    Process process(command(arguments), folder_.path());
    for (int i = 0; i < 6000 && !ready(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_TRUE(ready());
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    process.send(SIGTERM);
    const auto sent = Clock::now();
    const ProcessResult result = process.wait();
    EXPECT_LT(Clock::now() - sent, std::chrono::seconds(30));
    return result;
  }
};

TEST_F(ReliabilityTest, ResultsThatNobodyCanTakeAreNoSuccess) {
  for (const Arguments& more : std::vector<Arguments>{{}, {"--json"}, {"--dry-run"}}) {
    fs::remove_all(path("out"));
    const ProcessResult result = shell("", validate(more), "> /dev/full");
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr("the standard output cannot be written"));
    EXPECT_EQ(fs::exists(path("out")) ? status() : "failed", "failed");
  }
  EXPECT_EQ(shell("", {"--help"}, "> /dev/full").exit_code, 2);
}

TEST_F(ReliabilityTest, ThatNobodyReadsWarningsAndErrorsChangesNoExitCode) {
  EXPECT_EQ(shell("", validate({}), "2> /dev/full").exit_code, 0);
  EXPECT_EQ(shell("", {"validate", "nothing.yaml", "--poses", "poses.csv"}, "2> /dev/full").exit_code, 2);
  fs::remove_all(path("out"));
  EXPECT_EQ(shell("", validate({"--max-mje", "0.0001"}), "2> /dev/full").exit_code, 1);
}

TEST_F(ReliabilityTest, AFileThatMayNotGrowIsAnErrorWithAReason) {
  const ProcessResult result = shell("ulimit -f 40;", validate());  // the page has more than 20 KiB
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("File too large"));
  EXPECT_EQ(status(), "failed");
  EXPECT_FALSE(fs::exists(path("out/report.html")));
}

TEST_F(ReliabilityTest, NoMemoryIsSaid) {
#ifdef SIMGAP_SANITIZED
  GTEST_SKIP() << "the address sanitizer needs the address space that this test takes away";
#endif
  put("large.csv", text("poses.csv"));
  fs::resize_file(path("large.csv"), std::uintmax_t{2} << 30U);  // a hole: it takes no room on the disk
  const ProcessResult result =
      shell("ulimit -v 1500000;", {"validate", "arm.yaml", "--poses", "large.csv", "-q", "-o", "out"});
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_THAT(result.err, HasSubstr("simgap: not enough memory"));
}

TEST_F(ReliabilityTest, OneOfTwoRunsAtOnceIsRefused) {
  put("config.yaml", quickConfig(2000));
  put("out/run.json", "{}");
  Process first(command(calibrate("out", {"--force"})), folder_.path());
  for (int i = 0; i < 6000 && !fs::exists(path("out/config.resolved.yaml")); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  for (const Arguments& other : std::vector<Arguments>{validate({"--force"}), {"calibrate", "--resume", "out"}}) {
    const ProcessResult result = simgap(other);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr("out: another simgap is working there"));
  }
  first.send(SIGKILL);
  EXPECT_EQ(first.wait().signal, SIGKILL);
  succeed(validate({"--force"}));  // a killed process holds nothing
}

TEST_F(ReliabilityTest, WhatAKilledRunLeftIsReplaced) {
  put("out/.simgap-123-0.tmp", "half of run.json");
  succeed(validate({"--force"}));
  EXPECT_FALSE(fs::exists(path("out/.simgap-123-0.tmp")));
  put("out/.simgap-123-0.tmp", "half of a page");
  succeed({"report", "out"});
  EXPECT_FALSE(fs::exists(path("out/.simgap-123-0.tmp")));
}

TEST_F(ReliabilityTest, WaitingForAPipeCanBeEnded) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  EXPECT_EQ(interrupted({"validate", "pipe", "--poses", "poses.csv"}, [] { return true; }).exit_code, 130);
  const int writer = ::open(path("pipe").c_str(), O_RDWR | O_CLOEXEC);  // somebody who writes nothing
  ASSERT_GE(writer, 0);
  EXPECT_EQ(interrupted({"validate", "pipe", "--poses", "poses.csv"}, [] { return true; }).exit_code, 130);
  ::close(writer);
}

TEST_F(ReliabilityTest, AnEndlessFileCanBeEnded) {
  EXPECT_EQ(interrupted({"validate", "/dev/zero", "--poses", "poses.csv"}, [] { return true; }).exit_code, 130);
}

TEST_F(ReliabilityTest, DesignCanBeEnded) {
  put("poses.csv", readText(sourceFile("data/arm/poses_calibration.csv")));
  const Arguments arguments{"design",  "arm.yaml", "--poses", "poses.csv", "--candidates", "100000",
                            "--count", "1000",     "-q",      "-o",        "out"};
  const ProcessResult result = interrupted(arguments, [&] { return fs::exists(path("out/config.resolved.yaml")); });
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(status(), "interrupted");
}

TEST_F(ReliabilityTest, ASimulationCanBeEnded) {
  put("arm.yaml", readText(sourceFile("data/elbow-movement/arm.yaml")));
  put("schedule.yaml",
      replaced(readText(sourceFile("data/elbow-movement/schedule.yaml")), "duration_s: 3", "duration_s: 10000"));
  const ProcessResult result = interrupted({"simulate", "arm.yaml", "--commands", "schedule.yaml", "-q", "-o", "out"},
                                           [&] { return fs::exists(path("out/config.resolved.yaml")); });
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(status(), "interrupted");
}

TEST_F(ReliabilityTest, AMovementWithoutEndIsRefused) {
  put("arm.yaml", readText(sourceFile("data/elbow-movement/arm.yaml")));
  const std::string schedule = readText(sourceFile("data/elbow-movement/schedule.yaml"));
  put("schedule.yaml", replaced(schedule, "duration_s: 3", "duration_s: 1e9"));
  expectRefused({"simulate", "arm.yaml", "--commands", "schedule.yaml", "-q", "-o", "out"}, 2,
                "expected at most 1e+07 rows");
  put("schedule.yaml", schedule);
  const Arguments longer{"simulate", "arm.yaml", "--commands", "schedule.yaml", "--duration-s", "1e9",
                         "-q",       "-o",       "out"};
  const ProcessResult refused = simgap(longer);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, testing::HasSubstr("expected at most 1e+07 rows"));
}

TEST_F(ReliabilityTest, AServedArmThatWaitsForALineCanBeEnded) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  const int writer = ::open(path("pipe").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(writer, 0);
  Process process({"/bin/sh", "-c", std::string("exec '") + SIMGAP_BINARY + "' simulate arm.yaml --serve < pipe"},
                  folder_.path());
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  process.send(SIGTERM);
  EXPECT_EQ(process.wait().exit_code, 130);
  ::close(writer);
}

TEST_F(ReliabilityTest, ACalibrationOnMotionsCanBeEndedAndGoesOn) {
  put("forearm.yaml", reality::toYaml(movingForearm().arm));
  put("forearm_config.yaml", forearmConfig());
  putMotions(folder_, "motions.yaml", 0, 2);
  const auto calibration = [&](const char* directory) {
    return Arguments{"calibrate", "forearm.yaml", "--motions", "motions.yaml", "--config", "forearm_config.yaml",
                     "-q",        "-o",           directory,   "--threads",    "1"};
  };
  const auto stored = [&] { return fs::exists(path("out/state.json")); };
  const ProcessResult result = interrupted(calibration("out"), stored);
  if (result.exit_code != 0) {  // it was not over before the signal
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_EQ(status(), "interrupted");
    EXPECT_THAT(result.err, testing::HasSubstr("go on with: simgap calibrate --resume out"));
    succeed({"calibrate", "--resume", "out", "-q"});
  }
  succeed(calibration("whole"));
  for (const char* file : {"model.yaml", "parameters.csv", "residuals.csv"}) {
    EXPECT_EQ(text(std::string("out/") + file), text(std::string("whole/") + file)) << file;
  }
}

TEST_F(ReliabilityTest, NoNameWritesToTheTerminal) {
  const std::string name = "\x1b]0;title\x07\x1b[2J\xc2\x9b";
  put("evil.csv", replaced(text("poses.csv"), "1.71763311", name));
  const ProcessResult refused = simgap({"validate", "arm.yaml", "--poses", "evil.csv", "-o", "out"});
  EXPECT_EQ(refused.exit_code, 3);
  put("evil.csv", replaced(text("poses.csv"), "p001", name));
  const ProcessResult result = simgap({"validate", "arm.yaml", "--poses", "evil.csv", "-o", "out"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const std::string& shown : {refused.err, result.out, result.err, text("out/log.txt")}) {
    for (const char* control : {"\x1b", "\x07", "\xc2\x9b"}) EXPECT_EQ(shown.find(control), std::string::npos) << shown;
  }
}

TEST_F(ReliabilityTest, ALargeCellIsAbridged) {
  put("large.csv", replaced(text("poses.csv"), "1.71763311", std::string(1 << 20, 'x')));
  const ProcessResult result = simgap({"validate", "arm.yaml", "--poses", "large.csv", "-o", "out"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_LT(result.err.size(), 2100u);
  EXPECT_THAT(result.err, HasSubstr("expected a finite number"));
}

TEST_F(ReliabilityTest, NoNameIsAFormulaOfASpreadsheet) {
  const std::string name = "=cmd|' /C calc'!A0";
  put("evil.csv", replaced(text("poses.csv"), "p001", name));
  succeed({"validate", "arm.yaml", "--poses", "evil.csv", "-q", "-o", "out"});
  EXPECT_THAT(text("out/errors.csv"), HasSubstr("\n'" + name + ","));
  EXPECT_EQ(text("out/errors.csv").find("\n" + name), std::string::npos);
  EXPECT_THAT(text("out/report.html"), HasSubstr("calc"));
  EXPECT_EQ(Json::parse(text("out/result.json")).at("poses").at(1).at("pose"), name);
}

TEST_F(ReliabilityTest, NothingOutsideADirectoryIsWrittenOrRead) {
  put("config.yaml", quickConfig(1));
  succeed(calibrate("out"));
  put("precious.txt", "mine");
  fs::remove(path("out/log.txt"));
  fs::create_symlink(path("precious.txt"), path("out/log.txt"));
  ProcessResult result = simgap({"calibrate", "--resume", "out", "-q"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("out/log.txt: cannot be written: it is a link"));
  EXPECT_EQ(text("precious.txt"), "mine");
  fs::remove(path("out/log.txt"));

  const std::string inputs = text("out/inputs/inputs.json");
  for (const char* other : {"/etc/passwd", "inputs/../../arm.yaml", "../arm.yaml", "inputs/link.yaml", "inputs", ""}) {
    put("out/inputs/inputs.json", replaced(inputs, "inputs/model.yaml", other));
    std::error_code exists;
    fs::create_symlink(path("arm.yaml"), path("out/inputs/link.yaml"), exists);
    result = simgap({"calibrate", "--resume", "out", "-q"});
    EXPECT_EQ(result.exit_code, 2) << other;
    EXPECT_THAT(result.err, HasSubstr("expected a file in out/inputs"));
  }
  put("out/inputs/inputs.json", inputs);
  succeed({"calibrate", "--resume", "out", "-q"});
}

TEST_F(ReliabilityTest, ACalibrationOnMotionsThatGoesOnParsesOnlyWhatItHasReadBefore) {
  put("forearm.yaml", reality::toYaml(movingForearm().arm));
  put("forearm_config.yaml", forearmConfig() + "motions: {rounds: 1}\n");
  putMotions(folder_, "motions.yaml", 0, 1);
  succeed(
      {"calibrate", "forearm.yaml", "--motions", "motions.yaml", "--config", "forearm_config.yaml", "-q", "-o", "out"});
  const Arguments resume{"calibrate", "--resume", "out", "-q"};
  const std::string kept = text("out/inputs/motions.json"), model = text("forearm.yaml");
  // What a parser would quote in its sentence.
  const std::string secret = "secret_word: [";
  put("secret.yaml", secret);
  for (const char* role : {"model", "motions", "validation_motions", "poses"}) {
    Json edited = Json::parse(kept);
    edited.at(role) = path("secret.yaml").string();
    put("out/inputs/motions.json", toText(edited));
    const ProcessResult result = simgap(resume);
    EXPECT_EQ(result.exit_code, 2) << role;
    EXPECT_THAT(result.err, HasSubstr("secret.yaml: has changed since the run began")) << role;
    EXPECT_EQ(result.err.find("secret_word"), std::string::npos) << role;
  }
  put("out/inputs/motions.json", kept);
  put("forearm.yaml", secret);
  const ProcessResult changed = simgap(resume);
  EXPECT_EQ(changed.exit_code, 2);
  EXPECT_THAT(changed.err, HasSubstr("forearm.yaml: has changed since the run began"));
  put("forearm.yaml", model);
  succeed(resume);
}

TEST_F(ReliabilityTest, AbsurdValuesAreRefused) {
  for (const char* absurd : {"1e20", "-1e9"}) {
    put("bad.csv", replaced(text("poses.csv"), "1.71763311", absurd));
    expectRefused({"validate", "arm.yaml", "--poses", "bad.csv", "-o", "out"}, 3, "bad.csv:3: column elbow_rad: found");
  }
  put("bad.yaml", replaced(text("arm.yaml"), "mass_kg: 0.31", "mass_kg: 1e20"));
  expectRefused({"validate", "bad.yaml", "--poses", "poses.csv"}, 2, "expected a size of at most");
}

}  // namespace
}  // namespace simgap::test
