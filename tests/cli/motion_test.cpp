// Recorded motions from end to end: motions of an independent simulator, in whose arm friction, damping and lines are
// other than the model says.
#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"
#include "support/motions.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

constexpr double kCaptureDelay = 0.02;

class MotionTest : public CliTest {
 protected:
  MotionTest() {
    reality::MotionRigOptions options;
    options.capture_delay = kCaptureDelay;
    put("forearm.yaml", reality::toYaml(movingForearm().arm));
    put("forearm_config.yaml", forearmConfig());
    putMotions(folder_, "motions.yaml", 0, 2, options);
    putMotions(folder_, "unseen.yaml", 2, 2, options);
  }
  Arguments calibration(const std::string& directory, const Arguments& more = {}) const {
    Arguments all{"calibrate",   "forearm.yaml", "--motions",           "motions.yaml", "--validation-motions",
                  "unseen.yaml", "--config",     "forearm_config.yaml", "-q",           "-o",
                  directory};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Json resultOf(const std::string& directory) const { return Json::parse(text(directory + "/result.json")); }
};

TEST_F(MotionTest, CalibrationNarrowsTheGapOnMotionsItHasNotSeen) {
  succeed(calibration("out"));
  const Json result = resultOf("out");
  EXPECT_EQ(result.at("delivered"), "calibrated");
  const Json& unseen = result.at("motion_rms").at("validation");
  const double noise = result.at("noise").at("joint1_deg");
  EXPECT_NEAR(noise, 0.17, 0.03);
  EXPECT_GT(unseen.at("initial").at("joint1_deg").get<double>(), 3.0 * noise);
  EXPECT_TRUE(result.at("converged"));
  EXPECT_LT(unseen.at("final").at("joint1_deg").get<double>(), 1.3 * noise);
  EXPECT_TRUE(std::filesystem::exists(path("out/report.html")));
}

TEST_F(MotionTest, ThreadsDoNotChangeABit) {
  succeed(calibration("one", {"--threads", "1"}));
  succeed(calibration("two", {"--threads", "2"}));
  for (const char* file : {"model.yaml", "parameters.csv", "residuals.csv"}) {
    EXPECT_EQ(text(std::string("one/") + file), text(std::string("two/") + file)) << file;
  }
}

TEST_F(MotionTest, AnInterruptedRunGoesOnToTheSameEnd) {
  succeed(calibration("whole"));
  // What a run has stored after some rounds.
  succeed(calibration("parted"));
  Json state = Json::parse(text("parted/state.json"));
  ASSERT_GE(state.at("descent").at("history").size(), 5u);
  const std::string end = text("parted/parameters.csv");
  put("some_rounds.yaml", forearmConfig() + "motions: {rounds: 4}\n");
  Arguments first = calibration("begun");
  *std::ranges::find(first, "forearm_config.yaml") = "some_rounds.yaml";
  succeed(first);
  put("begun/config.resolved.yaml", text("whole/config.resolved.yaml"));
  succeed({"calibrate", "--resume", "begun", "-q"});
  EXPECT_EQ(text("begun/parameters.csv"), end);
  EXPECT_EQ(text("begun/model.yaml"), text("whole/model.yaml"));
}

TEST_F(MotionTest, ValidationTellsErrorNoiseAndLag) {
  const std::string printed = succeed({"validate", "forearm.yaml", "--motions", "motions.yaml", "-q", "-o", "out"});
  EXPECT_THAT(printed, HasSubstr("Worst seconds"));
  const Json result = resultOf("out");
  EXPECT_EQ(result.at("motions").size(), 2u);
  EXPECT_EQ(result.at("motions").at(0).at("channels").size(), 5u);
  const ProcessResult failed =
      simgap({"validate", "forearm.yaml", "--motions", "motions.yaml", "--max-rms", "0.1", "-q", "-o", "judged"});
  EXPECT_EQ(failed.exit_code, 1) << failed.err;
}

TEST_F(MotionTest, APopulationThatIsTooSmallForACmaEsIsRefused) {
  expectRefused(calibration("out", {"--optimizer", "cma-es", "--lambda", "3"}), 2,
                "found lambda = 3 with --optimizer cma-es, expected at least 5");
}

TEST_F(MotionTest, OptionsThatBelongElsewhereAreRefused) {
  expectRefused(calibration("out", {"--starts", "3"}), 2, "found --starts with --motions");
  expectRefused(calibration("out", {"--optimizer", "hybrid"}), 2, "expected lm, es or cma-es");
  expectRefused({"validate", "forearm.yaml", "-o", "out"}, 2, "either --poses or --motions");
  expectRefused({"validate", "forearm.yaml", "--motions", "motions.yaml", "--max-mje", "2", "-o", "out"}, 2,
                "found --max-mje with --motions");
  expectRefused({"validate", "arm.yaml", "--motions", "motions.yaml", "-q", "-o", "out"}, 3, "has no muscle 'muscle1'");
}

}  // namespace
}  // namespace simgap::test
