// Ways through `calibrate --motions` beside the descent on set-points: searches without derivatives, voltages, forces,
// rests beside motions, restarts, interruptions.
#include <signal.h>

#include <thread>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"
#include "support/motions.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

class MotionPathTest : public CliTest {
 protected:
  MotionPathTest() {
    put("forearm.yaml", reality::toYaml(movingForearm().arm));
    put("forearm_config.yaml", forearmConfig());
    reality::MotionRigOptions options;
    options.duration = 3.0;
    putMotions(folder_, "motions.yaml", 0, 2, options);
  }
  Arguments calibration(const std::string& directory, const Arguments& more = {}) const {
    Arguments all{"calibrate",           "forearm.yaml", "--motions", "motions.yaml", "--config",
                  "forearm_config.yaml", "-q",           "-o",        directory};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  static Arguments with(Arguments arguments, const std::string& from, const std::string& to) {
    *std::ranges::find(arguments, from) = to;
    return arguments;
  }
  Json resultOf(const std::string& directory) const { return Json::parse(text(directory + "/result.json")); }
  double jointError(const std::string& directory, const char* set, const char* when) const {
    return resultOf(directory).at("motion_rms").at(set).at(when).at("joint1_deg");
  }
  double parameter(const std::string& directory, const std::string& name, const char* number) const {
    const Json result = resultOf(directory);
    for (const Json& p : result.at("parameters")) {
      if (p.at("name") == name) return p.at(number);
    }
    ADD_FAILURE() << "no parameter " << name;
    return NAN;
  }
};

TEST_F(MotionPathTest, SearchesWithoutDerivativesNarrowTheGap) {
  succeed(calibration("es", {"--optimizer", "es", "--generations", "12"}));
  EXPECT_LT(jointError("es", "calibration", "final"), 0.2 * jointError("es", "calibration", "initial"));
  succeed(calibration("cma", {"--optimizer", "cma-es", "--lambda", "10", "--generations", "12"}));
  EXPECT_LT(jointError("cma", "calibration", "final"), 0.2 * jointError("cma", "calibration", "initial"));
}

TEST_F(MotionPathTest, AnInterruptedSearchWithoutDerivativesGoesOnToTheSameEnd) {
  for (const char* optimizer : {"es", "cma-es"}) {
    const std::string whole = std::string("whole-") + optimizer, parted = std::string("parted-") + optimizer;
    const Arguments search = {"--optimizer", optimizer, "--lambda", "10", "--generations", "8"};
    succeed(calibration(whole, search));
    Process process(command(calibration(parted, search)), folder_.path());
    for (int i = 0; i < 2000 && !std::filesystem::exists(path(parted + "/state.json")); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    process.send(SIGINT);
    const ProcessResult result = process.wait();
    if (result.exit_code != 0) {  // else it was at its end already
      EXPECT_THAT(result.err, HasSubstr("go on with: simgap calibrate --resume " + parted));
      succeed({"calibrate", "--resume", parted, "-q"});
    }
    EXPECT_EQ(text(parted + "/parameters.csv"), text(whole + "/parameters.csv"));
    EXPECT_EQ(text(parted + "/model.yaml"), text(whole + "/model.yaml"));
  }
}

TEST_F(MotionPathTest, AnInterruptedDescentGoesOnToTheSameEnd) {
  succeed(calibration("whole"));
  Process process(command(calibration("parted")), folder_.path());
  for (int i = 0; i < 2000 && !std::filesystem::exists(path("parted/state.json")); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  process.send(SIGINT);
  const ProcessResult result = process.wait();
  if (result.exit_code != 0) succeed({"calibrate", "--resume", "parted", "-q"});
  EXPECT_EQ(text("parted/parameters.csv"), text("whole/parameters.csv"));
}

TEST_F(MotionPathTest, RestsBesideMotionsTellMoreOfTheLines) {
  putRests(folder_, "rests.csv");
  // Of precise rests: what motions tell is known to a part of itself only, for the noise in their derivatives.
  put("forearm_config.yaml", forearmConfig() + "capture_sd_deg: 0.03\njoint_friction_in_noise: false\n");
  succeed(calibration("motions"));
  succeed(calibration("both", {"--poses", "rests.csv"}));
  const std::string line = "muscles.muscle1.kite_line_length_m";
  EXPECT_LT(parameter("both", line, "sd"), parameter("motions", line, "sd"));
  EXPECT_NEAR(parameter("both", line, "value"), 0.102, 3.0 * parameter("both", line, "sd"));
}

TEST_F(MotionPathTest, MotionsUnderVoltagesAreCalibrated) {
  putVoltageMotions(folder_, "volts.yaml", 0, 2);
  putVoltageMotions(folder_, "unseen.yaml", 2, 1);
  succeed(with(calibration("volts", {"--validation-motions", "unseen.yaml"}), "motions.yaml", "volts.yaml"));
  // Nothing holds a shaft but friction: what is wrong adds up over the whole motion.
  EXPECT_LT(jointError("volts", "validation", "final"), 0.2 * jointError("volts", "validation", "initial"));
  const Json predicted = resultOf("volts").at("predicted_motion_rms").at("validation");
  EXPECT_GE(jointError("volts", "validation", "final"), predicted.at("lower").at("joint1_deg").get<double>());
  EXPECT_LE(jointError("volts", "validation", "final"), predicted.at("upper").at("joint1_deg").get<double>());
}

TEST_F(MotionPathTest, MotionsUnderForceControlAreCalibrated) {
  // The rig's force controllers are those of the model: it recorded itself, with other friction of the joint.
  std::string truth = text("forearm.yaml");
  put("rig.yaml", replaced(truth, "viscous_friction_Nms: 0.03", "viscous_friction_Nms: 0.06"));
  put("sensors.yaml",
      "format: simgap/simulation/1\nsensors:\n  muscles: {shaft_noise_deg: 0.3, current_noise_A: 0.03}\n"
      "  joints: {rate_Hz: 60, noise_deg: 0.17}\n");
  std::string commands =
      "time_s,force_muscle1_N,force_muscle2_N\n0,20,20\n0.5,26,20\n1,18,24\n1.5,22,18\n2,20,20\n3,20,20\n";
  put("forces.csv", commands);
  succeed({"simulate", "rig.yaml", "--commands", "forces.csv", "--config", "sensors.yaml", "-q", "-o", "rig"});
  put("forces.yaml",
      "format: simgap/motions/1\nmotions:\n  - {name: f, muscles: rig/muscles.csv, joints: rig/joints.csv}\n");
  put("friction.yaml",
      "format: simgap/calibration/1\nparameters:\n  - {pattern: \"joints.*.viscous_friction_Nms\", step: "
      "5.0e-3, lower: 1.0e-4, upper: 10, prior_sd_percent: 50}\n");
  succeed(with(with(calibration("forces"), "motions.yaml", "forces.yaml"), "forearm_config.yaml", "friction.yaml"));
  const std::string name = "joints.joint1.viscous_friction_Nms";
  EXPECT_NEAR(parameter("forces", name, "value"), 0.06, 0.002);  // from 0.03; the fit's step is 2 ms, the rig's was 1
}

TEST_F(MotionPathTest, LongMotionsBeginAnewFromMeasuredStates) {
  reality::MotionRigOptions options;
  options.duration = 6.0;
  putMotions(folder_, "long.yaml", 0, 2, options);
  put("restart.yaml", forearmConfig() + "motions: {restart_s: 2}\n");
  succeed(with(with(calibration("out"), "motions.yaml", "long.yaml"), "forearm_config.yaml", "restart.yaml"));
  EXPECT_LT(jointError("out", "calibration", "final"), 1.5 * 0.17);
  succeed({"validate", "out/model.yaml", "--motions", "long.yaml", "--config", "restart.yaml", "-q", "-o", "pieces"});
  EXPECT_EQ(resultOf("pieces").at("motions").size(), 6u);
  EXPECT_EQ(resultOf("pieces").at("motions").at(1).at("name"), "m0 @ 2 s");
  put("short.yaml", forearmConfig() + "motions: {restart_s: 0.3}\n");
  expectRefused(with(calibration("no"), "forearm_config.yaml", "short.yaml"), 2, "expected 0 (never) or at least 1");
}

}  // namespace
}  // namespace simgap::test
