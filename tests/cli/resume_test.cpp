// A run that is killed or interrupted at any moment goes on to the bit-identical end, from its directory alone.
#include <signal.h>

#include <chrono>
#include <random>
#include <thread>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
using ::testing::HasSubstr;

class ResumeTest : public CliTest {
 protected:
  ResumeTest() { put("config.yaml", quickConfig(24)); }

  /// Names of the inputs the user gave; a resumed run must not need them.
  const std::vector<std::string> kInputs{"arm.yaml", "poses.csv", "config.yaml"};
  void hideInputs() const {
    for (const std::string& name : kInputs) fs::rename(path(name), path(name + ".hidden"));
  }
  void showInputs() const {
    for (const std::string& name : kInputs) fs::rename(path(name + ".hidden"), path(name));
  }

  static void sleep(double seconds) { std::this_thread::sleep_for(Seconds(seconds)); }

  /// Waits for a file; gives up after a minute.
  bool appears(const std::string& name) const {
    for (int i = 0; i < 60'000 && !fs::exists(path(name)); ++i) sleep(1e-3);
    return fs::exists(path(name));
  }

  /// Runs until done, killing it up to `kills` times; \returns how often a kill hit it.
  int runAndKill(const Arguments& start, const std::string& directory, int kills, double whole, std::mt19937& random) {
    std::uniform_real_distribution<double> moment(0.0, 0.3 * whole);
    int hits = 0;
    bool begun = false;
    while (true) {
      Process process(command(begun ? Arguments{"calibrate", "--resume", directory, "-q", "--threads", "2"} : start),
                      folder_.path());
      if (hits < kills) {
        sleep(moment(random));
        process.send(SIGKILL);
      }
      const ProcessResult result = process.wait();
      if (result.signal != SIGKILL) {
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return hits;
      }
      ++hits;
      if (!begun && fs::exists(path(directory + "/config.resolved.yaml"))) {
        begun = true;
        hideInputs();
      } else if (!begun) {
        EXPECT_EQ(simgap({"calibrate", "--resume", directory}).exit_code, 2);
        fs::remove_all(path(directory));
      }
    }
  }
};

TEST_F(ResumeTest, AfterKillsAtRandomMomentsTheEndIsTheSame) {
  const auto start = SteadyClock::now();
  succeed(calibrate("whole", {"--threads", "1"}));
  const double whole = Seconds(SteadyClock::now() - start).count();
  std::mt19937 random(20);
  int hits = 0;
  for (int run = 0; run < 12 && hits < 24; ++run) {
    const std::string directory = "killed" + std::to_string(run);
    hits += runAndKill(calibrate(directory), directory, 8, whole, random);
    EXPECT_EQ(found(directory), found("whole")) << "run " << run;
    EXPECT_EQ(text(directory + "/config.resolved.yaml"), text("whole/config.resolved.yaml"));
    EXPECT_EQ(Json::parse(text(directory + "/run.json")).at("status"), "done");
    if (!fs::exists(path("arm.yaml"))) showInputs();
  }
  EXPECT_GE(hits, 20);
}

class ResumeOptimiserTest : public ResumeTest, public testing::WithParamInterface<Arguments> {};

TEST_P(ResumeOptimiserTest, AfterKillsAtRandomMomentsTheEndIsTheSame) {
  put("poses.csv", readText(sourceFile("data/arm/poses_calibration.csv")));
  const auto start = SteadyClock::now();
  succeed(calibrate("whole", GetParam()));
  const double whole = Seconds(SteadyClock::now() - start).count();
  std::mt19937 random(7);
  int hits = 0;
  for (int run = 0; run < 8 && hits < 8; ++run) {
    const std::string directory = "killed" + std::to_string(run);
    hits += runAndKill(calibrate(directory, GetParam()), directory, 4, 2.0 * whole, random);
    EXPECT_EQ(found(directory), found("whole")) << "run " << run;
    if (!fs::exists(path("arm.yaml"))) showInputs();
  }
  EXPECT_GE(hits, 6);
}

TEST_P(ResumeOptimiserTest, CtrlCKeepsWhatIsFinished) {
  put("poses.csv", readText(sourceFile("data/arm/poses_calibration.csv")));
  succeed(calibrate("whole", GetParam()));
  Process process(command(calibrate("stopped", GetParam())), folder_.path());
  ASSERT_TRUE(appears("stopped/state.json"));
  process.send(SIGINT);
  const ProcessResult result = process.wait();
  ASSERT_EQ(result.exit_code, 130) << result.err;
  const Json state = Json::parse(text("stopped/state.json"));
  EXPECT_GT(state.at("journal").at("fits").size() + state.at("told").size(), 0u);
  EXPECT_LT(state.at("generation"), Json::parse(text("whole/state.json")).at("generation"));
  succeed({"calibrate", "--resume", "stopped", "-q"});
  EXPECT_EQ(found("stopped"), found("whole"));
}

INSTANTIATE_TEST_SUITE_P(All, ResumeOptimiserTest,
                         testing::Values(Arguments{"--optimizer", "cma-es", "--generations", "40"},
                                         Arguments{"--optimizer", "lm", "--starts", "400", "--verify", "none"},
                                         Arguments{"--optimizer", "hybrid", "--starts", "200", "--verify", "none"}));

TEST_F(ResumeTest, AKillInTheFirstMomentsLeavesADirectoryThatCanBeReplacedOrResumed) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> moment(0.0, 0.04);
  for (int i = 0; i < 25; ++i) {
    const std::string directory = "early" + std::to_string(i);
    {
      Process process(command(calibrate(directory, {"--generations", "1000"})), folder_.path());
      sleep(moment(random));
      process.send(SIGKILL);
      process.wait();
    }
    if (!fs::exists(path(directory + "/run.json"))) {
      // A bare folder, or one with the unfinished run.json in it.
      EXPECT_LE(entries(path(directory)).size(), 1u);
      continue;
    }
    const int resumable = simgap({"calibrate", "--resume", directory, "--dry-run"}).exit_code;
    EXPECT_EQ(resumable, fs::exists(path(directory + "/inputs/inputs.json")) ? 0 : 2) << directory;
    EXPECT_EQ(simgap({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "--force", "-o", directory}).exit_code, 0);
  }
}

TEST_F(ResumeTest, CtrlCSavesTheStateAndPrintsACommandThatWorks) {
  succeed(calibrate("whole"));
  const std::string directory = "it's a $HOME run";
  std::string resume;
  {
    Process process(command(calibrate(directory)), folder_.path());
    ASSERT_TRUE(appears(directory + "/state.json"));
    process.send(SIGINT);
    const ProcessResult result = process.wait();
    EXPECT_EQ(result.exit_code, 130);
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(countOf(result.err, "\n"), 1u) << result.err;
    EXPECT_THAT(result.err, ::testing::StartsWith("simgap: interrupted after "));
    const std::string before = "go on with: simgap ";
    ASSERT_THAT(result.err, HasSubstr(before));
    resume = result.err.substr(result.err.find(before) + before.size());
  }
  EXPECT_EQ(Json::parse(text(directory + "/run.json")).at("status"), "interrupted");
  EXPECT_FALSE(fs::exists(path(directory + "/result.json")));
  hideInputs();
  const ProcessResult result = runProcess({"/bin/sh", "-c", "'" SIMGAP_BINARY "' " + resume}, folder_.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(found(directory), found("whole"));
}

TEST_F(ResumeTest, CtrlCWhileTheResultIsJudgedCanBeResumedToo) {
  put("arm.yaml", readText(sourceFile("data/arm-dense/arm.yaml")));
  put("many.csv", readText(sourceFile("data/arm-dense/poses_calibration.csv")));
  put("config.yaml", quickConfig(1));
  const Arguments start = calibrate("out", {"--validation", "many.csv", "--threads", "1"});
  Process process(command(start), folder_.path());
  ASSERT_TRUE(appears("out/state.json"));
  process.send(SIGTERM);
  const ProcessResult result = process.wait();
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_THAT(result.err, HasSubstr("interrupted after 1 generations; go on with: simgap calibrate --resume out\n"));
  fs::remove(path("many.csv"));
  hideInputs();
  succeed({"calibrate", "--resume", "out", "-q"});
  EXPECT_TRUE(Json::parse(text("out/result.json")).at("mje_deg").contains("validation"));
}

TEST_F(ResumeTest, KeepsOptionsThatChangeHowInputsAreRead) {
  put("config.yaml", quickConfig(6));
  succeed(calibrate("plain", {"--seed", "5", "--target-fitness", "0"}));
  const std::string poses = text("poses.csv");
  const std::string bad = replaced(firstLines(poses, 2).substr(poses.find('\n') + 1), "0.727060496", "");
  put("poses.csv", gzipped(replaced(poses, "elbow_rad", "odd=elbow") + bad));
  const Arguments more{"--map", "elbow_rad=odd=elbow", "--skip-bad-rows", "--seed", "5", "--target-fitness", "0"};
  {
    Process process(command(calibrate("odd", more)), folder_.path());
    ASSERT_TRUE(appears("odd/state.json"));
    process.send(SIGKILL);
    process.wait();
  }
  hideInputs();
  succeed({"calibrate", "--resume", "odd", "-q"});
  EXPECT_EQ(found("odd"), found("plain"));
}

TEST_F(ResumeTest, AFinishedRunIsJudgedAgainAndStaysTheSame) {
  put("config.yaml", quickConfig(2));
  succeed(calibrate("out"));
  const std::string before = found("out");
  hideInputs();
  succeed({"calibrate", "--resume", "out", "-q"});
  EXPECT_EQ(found("out"), before);
}

TEST_F(ResumeTest, ADamagedStateIsRefused) {
  put("config.yaml", quickConfig(2));
  succeed(calibrate("out"));
  const std::string good = text("out/state.json");
  for (const std::string& bad : {std::string("{"), std::string("{}"), good.substr(0, good.size() / 2),
                                 replaced(good, "\"best_mje\": [", "\"best_mje\": [1.0,")}) {
    put("out/state.json", bad);
    const ProcessResult result = simgap({"calibrate", "--resume", "out", "-q"});
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_EQ(countOf(result.err, "\n"), 1u) << result.err;
    EXPECT_THAT(result.err, ::testing::StartsWith("simgap: "));
  }
}

}  // namespace
}  // namespace simgap::test
