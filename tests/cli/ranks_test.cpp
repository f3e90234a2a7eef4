// Runs on several ranks of mpirun: the same results as on one, whatever their number, and a state that resumes when one
// of them dies. Skipped where there is no mpirun.
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"
#include "support/motions.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;

/// The processes below one, youngest generation last.
std::vector<pid_t> descendants(pid_t of) {
  std::vector<pid_t> found{of};
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::string file = "/proc/" + std::to_string(found[i]) + "/task/" + std::to_string(found[i]) + "/children";
    std::ifstream children(file);
    for (pid_t child = 0; children >> child;) found.push_back(child);
  }
  return {found.begin() + 1, found.end()};
}

/// The rank of a process that mpirun started; -1: it is none.
int rankOf(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/environ");
  for (std::string word; std::getline(file, word, '\0');) {
    if (word.starts_with("OMPI_COMM_WORLD_RANK=")) return std::stoi(word.substr(word.find('=') + 1));
  }
  return -1;
}

class RanksTest : public CliTest {
 protected:
  void SetUp() override {
    if (!fs::exists("/usr/bin/mpirun")) GTEST_SKIP() << "there is no /usr/bin/mpirun (Debian: openmpi-bin)";
    allowLeaks();  // Open MPI's
    ::setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
    ::setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
    put("config.yaml", quickConfig(4));
  }

  static Arguments onRanks(int ranks, const Arguments& arguments) {
    Arguments all{"/usr/bin/mpirun", "--oversubscribe", "--bind-to", "none", "-n", std::to_string(ranks)};
    const Arguments alone = command(arguments);
    all.insert(all.end(), alone.begin(), alone.end());
    return all;
  }
  ProcessResult simgapOn(int ranks, const Arguments& arguments) const {
    return runProcess(onRanks(ranks, arguments), folder_.path());
  }
  void succeedOn(int ranks, const Arguments& arguments) const {
    const ProcessResult result = simgapOn(ranks, arguments);
    EXPECT_EQ(result.exit_code, 0) << testing::PrintToString(arguments) << "\n" << result.err;
  }

  /// Waits until the run has stored `generations` of them.
  bool reaches(const std::string& directory, int generations) const {
    for (int i = 0; i < 6000; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (!fs::exists(path(directory + "/state.json"))) continue;
      if (Json::parse(text(directory + "/state.json")).at("generation") >= generations) return true;
    }
    return false;
  }
};

class RanksOptimiserTest : public RanksTest, public testing::WithParamInterface<Arguments> {};

TEST_P(RanksOptimiserTest, AnyNumberOfRanksEndsTheSame) {
  const Arguments& more = GetParam();
  succeed(calibrate("alone", more));
  for (const int ranks : {1, 2, 3}) {
    const std::string directory = "on" + std::to_string(ranks);
    Arguments arguments = calibrate(directory, more);
    arguments.insert(arguments.end(), {"--threads", std::to_string(ranks)});
    succeedOn(ranks, arguments);
    EXPECT_EQ(found(directory), found("alone")) << ranks << " ranks";
    EXPECT_EQ(Json::parse(text(directory + "/run.json")).at("status"), "done");
  }
}

INSTANTIATE_TEST_SUITE_P(All, RanksOptimiserTest,
                         testing::Values(Arguments{}, Arguments{"--optimizer", "cma-es", "--generations", "2"},
                                         Arguments{"--optimizer", "lm", "--starts", "20"},
                                         Arguments{"--optimizer", "hybrid", "--starts", "4", "--verify", "none"}));

/// The files of a result, but for its page, its options, and what tells the time it took.
std::map<std::string, std::string> resultsIn(const fs::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(directory)) {
    const std::string name = entry.path().filename();
    if (!entry.is_regular_file() || name == "run.json" || name == "report.html" || name == "log.txt" ||
        name == "config.resolved.yaml")
      continue;
    files[name] = std::regex_replace(readText(entry.path()), std::regex("\"wall_s\":[^,\n]*"), "");
  }
  return files;
}

/// What every rank would do for itself if it were not shared: the same on any number of ranks and threads.
class SharedWorkTest : public RanksTest {
 protected:
  void expectTheSameOnRanks(const Arguments& arguments) const {
    const auto into = [&](const std::string& directory, int threads) {
      Arguments all = arguments;
      all.insert(all.end(), {"-o", directory, "--threads", std::to_string(threads)});
      return all;
    };
    succeed(into("alone", 1));
    const auto alone = resultsIn(path("alone"));
    EXPECT_TRUE(alone.contains("result.json"));
    for (const int ranks : {2, 3}) {
      const std::string directory = "on" + std::to_string(ranks);
      Arguments shared = into(directory, ranks - 1);
      shared.push_back("-v");
      const ProcessResult result = simgapOn(ranks, shared);
      EXPECT_EQ(result.exit_code, 0) << result.err;
      for (const auto& [name, content] : resultsIn(path(directory))) {
        ASSERT_TRUE(alone.contains(name)) << name;
        EXPECT_TRUE(content == alone.at(name)) << name << " differs on " << ranks << " ranks";
      }
      EXPECT_THAT(result.err, testing::HasSubstr("ranks: " + std::to_string(ranks)));
      EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("lists of tasks 0,")));
    }
  }
};

TEST_F(SharedWorkTest, RolloutsOfACalibrationOnMotions) {
  put("forearm.yaml", reality::toYaml(movingForearm().arm));
  put("forearm_config.yaml", forearmConfig() + "motions: {rounds: 2}\n");
  putMotions(folder_, "motions.yaml", 0, 2);
  expectTheSameOnRanks({"calibrate", "forearm.yaml", "--motions", "motions.yaml", "--config", "forearm_config.yaml"});
}

TEST_F(SharedWorkTest, MotionsThatAreValidated) {
  put("forearm.yaml", reality::toYaml(movingForearm().arm));
  putMotions(folder_, "motions.yaml", 0, 3);
  expectTheSameOnRanks({"validate", "forearm.yaml", "--motions", "motions.yaml"});
}

class DiagnosedMotionsTest : public SharedWorkTest {
 protected:
  DiagnosedMotionsTest() {
    reality::MotionRigOptions options;
    options.duration = 2.0;
    options.capture_delay = 0.05;
    put("forearm.yaml", reality::toYaml(movingForearm().arm));
    put("forearm_config.yaml", forearmConfig());
    putMotions(folder_, "motions.yaml", 0, 4, options);
    putMotions(folder_, "unseen.yaml", 4, 3, options);
    putMotions(folder_, "further.yaml", 7, 3, options);
  }
  const Arguments diagnosis_{
      "diagnose",    "forearm.yaml", "--motions",           "motions.yaml", "--validation-motions",
      "unseen.yaml", "--config",     "forearm_config.yaml", "--effects",    "joint-clock-offset,payload"};
};

TEST_F(DiagnosedMotionsTest, RolloutsOfADiagnosis) { expectTheSameOnRanks(diagnosis_); }

TEST_F(DiagnosedMotionsTest, RolloutsOfAnIntervention) {
  Arguments once = diagnosis_;
  once.insert(once.end(), {"-q", "-o", "why"});
  succeed(once);
  expectTheSameOnRanks({"intervene", "why", "--motions", "further.yaml"});
}

class SlowSharedWorkTest : public SharedWorkTest {};

TEST_F(SlowSharedWorkTest, HypothesesAndPlacebosOfALog) {
  expectTheSameOnRanks({"diagnose", "classic", "--log", sourceFile("data/logs/bend-friction.csv.gz").string(),
                        "--effects", "bend-friction,channel-delay", "--max-causes", "1"});
}

TEST_F(SlowSharedWorkTest, HiddenCausesOfAPoseSet) {
  put("poses.csv", readText(sourceFile("data/arm-dense/poses_calibration.csv")));
  expectTheSameOnRanks({"diagnose", "arm.yaml", "--poses", "poses.csv", "--effects", "payload,gravity-tilt",
                        "--max-causes", "1", "--self-test", "1"});
}

TEST_F(SharedWorkTest, HypothesesOfAPoseSet) {
  put("poses.csv", readText(sourceFile("data/arm/poses_calibration.csv")));
  expectTheSameOnRanks({"diagnose", "arm.yaml", "--poses", "poses.csv", "--effects", "payload,muscle-wrap"});
}

TEST_F(SharedWorkTest, ACalibrationOnMotionsThatWasStoppedGoesOnOnRanks) {
  put("forearm.yaml", reality::toYaml(movingForearm().arm));
  putMotions(folder_, "motions.yaml", 0, 1);
  const auto calibration = [&](const std::string& directory, int rounds) {
    put("config.yaml", forearmConfig() + "motions: {rounds: " + std::to_string(rounds) + "}\n");
    return Arguments{"calibrate",   "forearm.yaml", "--motions", "motions.yaml", "--config",
                     "config.yaml", "-q",           "-o",        directory};
  };
  succeed(calibration("whole", 2));
  succeed(calibration("begun", 1));
  put("begun/config.resolved.yaml", text("whole/config.resolved.yaml"));
  succeedOn(2, {"calibrate", "--resume", "begun", "-q"});
  EXPECT_EQ(text("begun/parameters.csv"), text("whole/parameters.csv"));
}

TEST_F(RanksTest, OnlyTheFirstRankSpeaks) {
  const ProcessResult alone = simgap({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "alone"});
  const ProcessResult both = simgapOn(3, {"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "both"});
  EXPECT_EQ(both.exit_code, alone.exit_code);
  EXPECT_EQ(replaced(both.out, "both", "alone"), alone.out);
  const ProcessResult refused = simgapOn(2, {"validate", "none.yaml", "--poses", "poses.csv"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(countOf(refused.err, "simgap: none.yaml: cannot be read"), 1u) << refused.err;
}

/// Ends rank 2 of what this process has started.
bool killRankTwo() {
  bool killed = false;
  for (const pid_t child : descendants(::getpid())) {
    if (rankOf(child) == 2 && ::kill(child, SIGKILL) == 0) killed = true;
  }
  return killed;
}

TEST_F(RanksTest, ARunThatLostARankGoesOnOnAnotherNumber) {
  // Open MPI asks the others to end a second after the death; a shorter run would be over by then.
  put("config.yaml", quickConfig(160));
  succeed(calibrate("whole"));
  Arguments arguments = onRanks(3, calibrate("killed", {"--threads", "1"}));
  Process process(arguments, folder_.path());
  ASSERT_TRUE(reaches("killed", 2));
  ASSERT_TRUE(killRankTwo());
  const ProcessResult result = process.wait();
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, testing::HasSubstr("go on with: simgap calibrate --resume killed"));
  EXPECT_NE(Json::parse(text("killed/run.json")).at("status"), "done");
  EXPECT_LT(Json::parse(text("killed/state.json")).at("generation"), 160);
  succeedOn(2, {"calibrate", "--resume", "killed", "-q"});
  EXPECT_EQ(found("killed"), found("whole"));
}

TEST_F(RanksTest, ACalibrationOnMotionsThatLostARankGoesOnOnAnotherNumber) {
  put("forearm.yaml", reality::toYaml(movingForearm().arm));
  put("config.yaml", forearmConfig());
  putMotions(folder_, "motions.yaml", 0, 2);
  const auto calibration = [](const std::string& directory) {
    return Arguments{"calibrate",
                     "forearm.yaml",
                     "--motions",
                     "motions.yaml",
                     "--config",
                     "config.yaml",
                     "--optimizer",
                     "es",
                     "--mu",
                     "3",
                     "--lambda",
                     "9",
                     "--generations",
                     "30",
                     "--threads",
                     "1",
                     "-q",
                     "-o",
                     directory};
  };
  succeed(calibration("whole"));
  Process process(onRanks(3, calibration("killed")), folder_.path());
  for (int i = 0; i < 6000 && !fs::exists(path("killed/state.json")); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_TRUE(killRankTwo());
  const ProcessResult result = process.wait();
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, testing::HasSubstr("go on with: simgap calibrate --resume killed"));
  EXPECT_NE(Json::parse(text("killed/run.json")).at("status"), "done");
  succeedOn(2, {"calibrate", "--resume", "killed", "-q"});
  EXPECT_EQ(resultsIn(path("killed")), resultsIn(path("whole")));
}

TEST_F(RanksTest, AnInterruptedRunGoesOnWithoutRanks) {
  put("config.yaml", quickConfig(40));
  succeed(calibrate("whole"));
  Process process(onRanks(2, calibrate("stopped")), folder_.path());
  ASSERT_TRUE(reaches("stopped", 2));
  for (const pid_t child : descendants(::getpid())) {
    if (rankOf(child) == 0) ::kill(child, SIGINT);
  }
  const ProcessResult result = process.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(Json::parse(text("stopped/run.json")).at("status"), "interrupted");
  succeed({"calibrate", "--resume", "stopped", "-q"});
  EXPECT_EQ(found("stopped"), found("whole"));
}

}  // namespace
}  // namespace simgap::test
