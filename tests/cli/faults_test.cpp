// What a run leaves when the disk fails it: every call that writes fails once in turn, and from each one on.
#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"
#include "support/motions.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;

class FaultsTest : public CliTest {
 protected:
  /// Runs in which the writing call `at` into `out` fails.
  ProcessResult runFailing(const Arguments& arguments, long at, const std::string& on) const {
    Arguments all{"/usr/bin/env", std::string("LD_PRELOAD=") + SIMGAP_FAIL_WRITES, "FAIL_UNDER=" + out(),
                  "FAIL_AT=" + std::to_string(at), "FAIL_ON=" + on, "FAIL_COUNT=" + path("count").string(),
                  // The sanitizer asks to be the first library; what lets writes fail comes before it.
                  "ASAN_OPTIONS=detect_leaks=0:verify_asan_link_order=0"};
    for (const std::string& word : command(arguments)) all.push_back(word);
    return runProcess(all, folder_.path());
  }
  /// The same into a folder that is made anew.
  ProcessResult runAnewFailing(const Arguments& arguments, long at, const std::string& on) const {
    fs::remove_all(path("out"));
    return runFailing(arguments, at, on);
  }
  /// Of the run, as the system knows it: the shim compares names.
  std::string out() const { return (fs::canonical(folder_.path()) / "out").string(); }
  long calls() const { return std::stol(text("count")); }

  /// What must be the same in every complete run.
  std::map<std::string, std::string> results() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(path("out"))) {
      const std::string name = entry.path().filename();
      if (!entry.is_regular_file() || name == "run.json" || name == "report.html" || name == "log.txt") continue;
      files[name] = std::regex_replace(readText(entry.path()), std::regex("\"(wall_s|real_time_factor)\":[^,\n]*"), "");
    }
    return files;
  }
  std::string status() const {
    if (!fs::exists(path("out/run.json"))) return "no run.json";
    return Json::parse(text("out/run.json")).at("status");
  }

  /// \param stride  every call fails in turn, or one in so many
  void expectCompleteOrSaysNot(const Arguments& arguments, const std::string& on, long stride = 1) const {
    ASSERT_EQ(runAnewFailing(arguments, 0, on).exit_code, 0);
    ASSERT_EQ(status(), "done");
    const auto complete = results();
    const long count = calls();
    ASSERT_GT(count, 20) << "the shim saw no writes";
    long failed = 0, runs = 0;
    for (long at = 1; at <= count; at += stride, ++runs) {
      SCOPED_TRACE("call " + std::to_string(at) + " of " + std::to_string(count) + " fails " + on);
      const ProcessResult result = runAnewFailing(arguments, at, on);
      EXPECT_EQ(result.signal, 0) << result.err;
      if (result.exit_code == 0) {
        EXPECT_EQ(status(), "done");
        EXPECT_EQ(results(), complete);
        EXPECT_TRUE(fs::exists(path("out/report.html")));
        continue;
      }
      ++failed;
      EXPECT_EQ(result.exit_code, 2) << result.err;
      EXPECT_THAT(result.err, testing::HasSubstr("No space left on device"));
      EXPECT_NE(status(), "done");
    }
    EXPECT_GT(failed, runs / 2) << "most failures are noticed";
  }
  void expectCompleteOrSaysNot(const Arguments& arguments, long stride) const {
    for (const char* on : {"once", "forever"}) expectCompleteOrSaysNot(arguments, on, stride);
  }

  /// A short motion of a forearm and what calibrate needs for it.
  Arguments motionCalibration() const {
    put("forearm.yaml", reality::toYaml(movingForearm().arm));
    put("forearm_config.yaml", forearmConfig() + "motions: {rounds: 1}\n");
    putMotions(folder_, "motions.yaml", 0, 1);
    return {"calibrate",           "forearm.yaml", "--motions", "motions.yaml", "--config",
            "forearm_config.yaml", "-q",           "-o",        out()};
  }
};

TEST_F(FaultsTest, ARunIsCompleteOrSaysItIsNotWhenOneWriteFails) {
  expectCompleteOrSaysNot({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", out()}, "once");
}

TEST_F(FaultsTest, ARunIsCompleteOrSaysItIsNotOnADiskThatIsFullFromThereOn) {
  expectCompleteOrSaysNot({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", out()}, "forever");
}

TEST_F(FaultsTest, AResumedRunAfterAFailureEndsAsIfThereHadBeenNone) {
  const Arguments arguments = calibrate(out());
  ASSERT_EQ(runAnewFailing(arguments, 0, "once").exit_code, 0);
  const std::string undisturbed = found("out");
  const long count = calls();
  long resumed = 0;
  for (long at = count / 3; at <= count; at += count / 6) {
    SCOPED_TRACE("call " + std::to_string(at) + " of " + std::to_string(count));
    if (runAnewFailing(arguments, at, "forever").exit_code == 0 || !fs::exists(path("out/inputs/inputs.json")))
      continue;
    ++resumed;
    succeed({"calibrate", "--resume", "out", "-q"});
    EXPECT_EQ(status(), "done");
    EXPECT_EQ(found("out"), undisturbed);
  }
  EXPECT_GT(resumed, 0);
}

TEST_F(FaultsTest, ASimulationIsCompleteOrSaysItIsNot) {
  for (const char* name : {"arm.yaml", "schedule.yaml"}) {
    put(name, readText(sourceFile("data/elbow-movement") / name));
  }
  expectCompleteOrSaysNot({"simulate", "arm.yaml", "--commands", "schedule.yaml", "-q", "-o", out()}, 5);
}

TEST_F(FaultsTest, AComparisonAndAGuardAreCompleteOrSayTheyAreNot) {
  succeed(calibrate("a"));
  succeed(calibrate("b", {"--seed", "2"}));
  expectCompleteOrSaysNot({"compare", "a", "b", "-q", "-o", out()}, 5);
  put("budget.yaml", "format: simgap/budget/1\nlimits:\n  - {value: evaluations, lower: 0}\n");
  expectCompleteOrSaysNot({"guard", "budget.yaml", "a", "-q", "-o", out()}, 5);
}

TEST_F(FaultsTest, ACalibrationOnMotionsIsCompleteOrSaysItIsNot) {
  const Arguments arguments = motionCalibration();
  expectCompleteOrSaysNot(arguments, "once", 9);
  expectCompleteOrSaysNot(arguments, "forever", 13);
}

TEST_F(FaultsTest, AConvertedRobotIsWholeOrNotThere) {
  const Arguments arguments{"convert", "arm.yaml", out() + "/arm.xml", "--force", "-q"};
  const auto converted = [&](long at, const std::string& on, const std::string& before) {
    fs::remove_all(path("out"));
    fs::create_directory(path("out"));
    if (!before.empty()) put("out/arm.xml", before);
    return runFailing(arguments, at, on);
  };
  for (const std::string before : {"", "<mujoco/>"}) {
    ASSERT_EQ(converted(0, "once", before).exit_code, 0);
    const std::string whole = text("out/arm.xml");
    const long count = calls();
    ASSERT_GE(count, 4);
    for (const char* on : {"once", "forever"}) {
      for (long at = 1; at <= count; ++at) {
        SCOPED_TRACE("call " + std::to_string(at) + " of " + std::to_string(count) + " fails " + on);
        const ProcessResult result = converted(at, on, before);
        EXPECT_EQ(result.signal, 0);
        const std::string left = fs::exists(path("out/arm.xml")) ? text("out/arm.xml") : "";
        if (result.exit_code == 0) {
          EXPECT_EQ(left, whole);
        } else {
          EXPECT_EQ(result.exit_code, 2) << result.err;
          EXPECT_TRUE(left == before || left == whole) << "half of a file";
        }
      }
    }
  }
}

}  // namespace
}  // namespace simgap::test
