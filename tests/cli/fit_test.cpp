// The fit commands as a user runs them.
#include <algorithm>
#include <cmath>

#include "cli/cli_fixture.h"
#include "reality/friction_log.h"
#include "reality/motor_log.h"
#include "simgap/core/run_directory.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsSupersetOf;

class FitTest : public CliTest {
 protected:
  FitTest() {
    reality::FrictionTruth truth;
    truth.sliding_offset = 1.2;
    put("log.csv", reality::simulateFrictionLog(truth, {.rows = 6000, .sessions = 6}).csv());
  }
  Json result(const std::string& directory) const { return Json::parse(text(directory + "/result.json")); }
};

TEST_F(FitTest, FrictionComparesThePapersModels) {
  const std::string table = succeed({"fit-friction", "log.csv", "-o", "f"});
  EXPECT_THAT(table, HasSubstr("variant-a *"));
  const Json json = result("f");
  EXPECT_EQ(json.at("format"), "simgap/fit-friction/1");
  EXPECT_EQ(json.at("model"), "variant-a");
  ASSERT_EQ(json.at("comparison").size(), 3u);
  EXPECT_EQ(json.at("comparison")[0].at("model"), "classic");
  EXPECT_GT(json.at("starts").at("tried").get<int>(), 500);
  EXPECT_LT(json.at("n_effective").get<double>(), 1.0 + json.at("n").get<double>());
  for (const Json& p : json.at("parameters")) {
    EXPECT_TRUE(p.contains("ci95") && p.contains("at_bound") && p.contains("sd"));
  }
  EXPECT_THAT(entries(path("f")), IsSupersetOf({"comparison.csv", "config.resolved.yaml", "log.txt", "maps.csv",
                                                "model.yaml", "profile.csv", "report.html", "run.json", "series.csv"}));
}

TEST_F(FitTest, HeldOutSessionsAreNotSeen) {
  succeed({"fit-friction", "log.csv", "--model", "variant-a", "--holdout", "session=4,5", "-o", "f"});
  const Json json = result("f");
  EXPECT_EQ(json.at("heldout"), "session=4,5");
  EXPECT_LE(json.at("n").get<int>(), 4000);
  EXPECT_GT(json.at("mse_heldout").get<double>(), 0.0);
  expectRefused({"fit-friction", "log.csv", "--holdout", "session=9", "-o", "g"}, 3, "found no row whose session is 9");
  expectRefused({"fit-friction", "log.csv", "--holdout", "2", "-o", "g"}, 2, "a fraction between 0 and 1");
}

TEST_F(FitTest, FixedAndBoundedParametersAreChecked) {
  succeed({"fit-friction", "log.csv", "--model", "coulomb", "--fix", "k_a=1.3", "-o", "f"});
  EXPECT_EQ(result("f").at("parameters")[0].at("value"), 1.3);
  expectRefused({"fit-friction", "log.csv", "--fix", "k_z=1", "-o", "g"}, 2, "found the parameter k_z");
  expectRefused({"fit-friction", "log.csv", "--fix", "k_a=one", "-o", "g"}, 2, "expected a number");
  expectRefused({"fit-friction", "log.csv", "--bounds", "k_v=3:1", "-o", "g"}, 2, "lower bound below the upper");
  expectRefused({"fit-friction", "log.csv", "--model", "magic", "-o", "g"}, 2, "expected one of");
  expectRefused({"fit-friction", "log.csv", "--fix", "k_v=-1", "-o", "g"}, 2, "--fix k_v: found -1, expected a number");
  put("motor.csv", reality::simulateMotor({}, {.seconds = 1.0}).csv());
  expectRefused({"fit-motor", "motor.csv", "--fix", "eta=0.5", "-o", "g"}, 2, "--fix: found the parameter eta");
  expectRefused({"fit-motor", "motor.csv", "--fix", "R=-1", "-o", "g"}, 2, "--fix R: found -1, expected a number > 0");
}

TEST_F(FitTest, BadLogsSayWhatToRecord) {
  const std::string log = text("log.csv");
  put("no_torque.csv", replaced(log, "external_torque_Nm", "torque"));
  expectRefused({"fit-friction", "no_torque.csv", "-o", "g"}, 3, "expected it, or --bench");
  put("scale.csv", replaced(log, "motor_current_A", "motor_current_mA"));
  put("huge.csv",
      "time_s,motor_current_A,motor_velocity_rad_s,external_torque_Nm\n0,10000,1,1\n1,9000,-1,2\n2,1,1,3\n");
  expectRefused({"fit-friction", "huge.csv", "-o", "g"}, 3, "is the unit in the column's name right?");
  put("still.csv", "time_s,motor_current_A,motor_velocity_rad_s,external_torque_Nm\n0,1,0,1\n1,2,0,2\n2,1,0,3\n");
  expectRefused({"fit-friction", "still.csv", "-o", "g"}, 3, "record slow and fast motion in both directions");
  put("back.csv", "time_s,motor_current_A,motor_velocity_rad_s,external_torque_Nm\n0,1,0,1\n1,2,1,2\n0,1,0,3\n");
  expectRefused({"fit-friction", "back.csv", "-o", "g"}, 3, "back.csv:4: time goes from 1 s to 0 s");
  expectRefused({"fit-friction", "no_such.csv", "-o", "g"}, 2, "cannot be read");
}

TEST_F(FitTest, PredictionsFollowTheFittedModel) {
  succeed({"fit-friction", "log.csv", "--model", "variant-a", "-o", "f"});
  succeed({"predict", "f/model.yaml", "log.csv", "-o", "p"});
  const double rms = Json::parse(text("p/result.json")).at("rms_error");
  const double mse = result("f").at("mse");
  EXPECT_NEAR(rms * rms, mse, 1e-9 * mse);
  EXPECT_THAT(text("p/prediction.csv"),
              testing::StartsWith("time_s,motor_current_predicted_A,motor_current_measured_A\n"));
  put("model.yaml", replaced(text("f/model.yaml"), "extensions: []", "extensions: [{effect: magic, parameters: {}}]"));
  expectRefused({"predict", "model.yaml", "log.csv", "-o", "q"}, 2, "found no effect 'magic'");
}

TEST_F(FitTest, FreeAxisReadsItsRig) {
  std::string csv = "time_s,motor_force_N,position_m\n";
  for (int i = 0; i < 4000; ++i) {
    const double t = 1e-3 * i, w = 6.283185307 * 0.8;
    const double x = 0.2 * std::sin(w * t), v = 0.2 * w * std::cos(w * t), a = -0.2 * w * w * std::sin(w * t);
    csv += std::to_string(t) + "," + std::to_string(20.0 * a + 50.0 * v + (v > 0 ? 8.0 : -8.0) + 3.0) + "," +
           std::to_string(x) + "\n";
  }
  put("axis.csv", csv);
  put("rig.yaml", "format: simgap/bench/1\nload: free-axis\nmass_kg: fit\nbandwidth_Hz: 40\n");
  succeed({"fit-friction", "axis.csv", "--bench", "rig.yaml", "--model", "coulomb", "--offset", "--fix", "k_a=1", "-o",
           "f"});
  const Json json = result("f");
  const auto value = [&](const std::string& name) {
    for (const Json& p : json.at("parameters")) {
      if (p.at("name") == name) return p.at("value").get<double>();
    }
    return 0.0;
  };
  EXPECT_NEAR(value("mass"), 20.0, 0.1);
  EXPECT_NEAR(value("k_v"), 50.0, 0.5);
  EXPECT_NEAR(value("tau_c"), 8.0, 0.1);
  EXPECT_NEAR(value("offset"), 3.0, 0.05);
  expectRefused({"fit-friction", "axis.csv", "--bench", "rig.yaml", "--model", "coulomb", "-o", "g"}, 3,
                "only their ratio");
  put("rig.yaml", "format: simgap/bench/1\nload: free-axis\nmass: 3\n");
  expectRefused({"fit-friction", "axis.csv", "--bench", "rig.yaml", "-o", "g"}, 2, "rig.yaml");
}

TEST_F(FitTest, MotorAndGearboxGoIntoAnArm) {
  reality::MotorTruth truth;
  put("motor.csv", reality::simulateMotor(truth, {.seconds = 2.0, .current_noise = 0.05, .velocity_noise = 1.0}).csv());
  succeed({"fit-motor", "motor.csv", "--into", "arm.yaml", "--muscle", "biceps", "-o", "m"});
  EXPECT_THAT(text("m/arm.yaml"), HasSubstr("    motor: {resistance_ohm: 0."));
  EXPECT_THAT(text("m/calibration_parameters.yaml"), HasSubstr("muscles.biceps.motor.resistance_ohm"));
  succeed({"validate", "m/arm.yaml", "--poses", "poses.csv", "--config", "config.yaml", "-q", "-o", "v"});
  truth.ratio = 72.0;
  truth.efficiency = 0.7;
  truth.gear_coulomb = 0.03;
  truth.gear_inertia = 1e-3;
  put("gear.csv",
      reality::simulateMotor(truth, {.seconds = 2.0, .load = 0.6, .current_noise = 0.02, .velocity_noise = 1.0}).csv());
  succeed({"fit-gearbox", "gear.csv", "--motor", "m/model.yaml", "--ratio", "72", "--into", "m/arm.yaml", "--muscle",
           "biceps", "-o", "g"});
  EXPECT_EQ(result("g").at("parameters").size(), 4u);
  expectRefused(
      {"fit-gearbox", "gear.csv", "--motor", "m/model.yaml", "--ratio", "72", "--bounds", "R=0.1:0.2", "-o", "x"}, 2,
      "--bounds R: found a parameter of the motor, which --motor tells");
  succeed({"predict", "g/model.yaml", "gear.csv", "--motor", "m/model.yaml", "-o", "p"});
  put("none.yaml", std::regex_replace(text("m/model.yaml"), std::regex("  L: .value: [^,]*,"), "  L: {value: 0,"));
  expectRefused({"predict", "none.yaml", "motor.csv", "-o", "x"}, 2, "none.yaml: found L = 0, expected a number > 0");
  put("none.yaml", replaced(text("arm.yaml"), "inductance_H: 0.0003", "inductance_H: 0"));
  expectRefused({"validate", "none.yaml", "--poses", "poses.csv", "-o", "x"}, 2,
                "inductance_H: found 0, expected a number > 0 (1e-6 H stands for a winding without a lag)");
  expectRefused({"predict", "m/model.yaml", "motor.csv", "--ratio", "72", "-o", "x"}, 2,
                "found --ratio with the motor model m/model.yaml, expected it with a drive's friction");
  expectRefused({"predict", "m/model.yaml", "motor.csv", "--motor", "m/model.yaml", "-o", "x"}, 2, "found --motor");
  expectRefused({"fit-motor", "motor.csv", "--into", "arm.yaml", "--muscle", "wing", "-o", "x"}, 2,
                "found no muscle wing");
  expectRefused({"fit-motor", "motor.csv", "--into", "arm.yaml", "-o", "x"}, 2, "go together");
}

/// What was not found is written nowhere as if it had been.
// On the very log that a motor was fitted to its prediction was four times as far off: it did not know the delays.
TEST_F(FitTest, PredictsAMotorWithTheDelaysThatItsFitFound) {
  const reality::MotorDesign design{
      .seconds = 3.0, .current_noise = 0.02, .velocity_noise = 0.2, .voltage_late = 0.5, .seed = 5};
  put("motor.csv", reality::simulateMotor({}, design).csv());
  succeed({"fit-motor", "motor.csv", "-o", "m"});
  EXPECT_THAT(text("m/model.yaml"), HasSubstr("voltage_delay_s"));
  succeed({"predict", "m/model.yaml", "motor.csv", "-o", "p"});
  const double fitted = std::sqrt(result("m").at("mse").get<double>());
  EXPECT_NEAR(Json::parse(text("p/result.json")).at("rms_error").get<double>(), fitted, 0.01 * fitted);
}

TEST_F(FitTest, AMotorUnderAnUnloggedLoadLeavesAnArmItsMechanics) {
  const reality::MotorBenchLog log =
      reality::simulateMotor({}, {.seconds = 2.0, .current_noise = 0.05, .velocity_noise = 1.0});
  put("motor.csv", log.csv(true, false));
  succeed({"fit-motor", "motor.csv", "--into", "arm.yaml", "--muscle", "biceps", "-o", "m"});
  EXPECT_THAT(result("m").at("warnings").dump(), HasSubstr("something acts on the motor that the log does not hold"));
  EXPECT_THAT(result("m").at("warnings").dump(), HasSubstr("arm.yaml keeps the arm's own J_M, mu_M, tau_CM"));
  EXPECT_TRUE(result("m").at("parameters")[4].at("value").is_null());
  EXPECT_EQ(text("m/model.yaml").find("J_M"), std::string::npos);
  EXPECT_EQ(text("m/response.csv").find("velocity_simulated"), std::string::npos);
  const auto biceps = [&](const std::string& file) {
    const ArmModel arm = readArm(YamlNode::load(path(file)));
    return std::ranges::find(arm.muscles, "biceps", &Muscle::name)->motor;
  };
  EXPECT_EQ(biceps("m/arm.yaml").inertia, biceps("arm.yaml").inertia);
  EXPECT_EQ(biceps("m/arm.yaml").coulomb_friction, biceps("arm.yaml").coulomb_friction);
  EXPECT_NEAR(biceps("m/arm.yaml").resistance, 0.8, 0.01);
  expectRefused({"predict", "m/model.yaml", "motor.csv", "-o", "p"}, 2,
                "m/model.yaml: found no parameter J_M in the motor model");
  expectRefused({"fit-gearbox", "motor.csv", "--motor", "m/model.yaml", "--ratio", "72", "-o", "g"}, 2,
                "m/model.yaml: found no parameter J_M in the motor model");
}

TEST_F(FitTest, ThreadsArriveAndChangeNothing) {
  put("motor.csv", reality::simulateMotor({}, {.seconds = 1.0, .current_noise = 0.05}).csv());
  std::string first;
  for (const char* threads : {"1", "2"}) {
    const std::string out = std::string("t") + threads;
    succeed({"fit-motor", "motor.csv", "--threads", threads, "-o", out});
    EXPECT_THAT(text(out + "/log.txt"), HasSubstr(std::string("threads: ") + threads + "\n"));
    if (first.empty()) first = text(out + "/result.json");
    EXPECT_EQ(text(out + "/result.json"), first) << threads;
  }
}

TEST_F(FitTest, PamWithAndWithoutItsSpring) {
  std::string csv = "pressure_kPa,contraction,force_N\n";
  for (int p = 1; p <= 6; ++p) {
    for (int e = 0; e <= 20; ++e) {
      const double pressure = 1e5 * p, eps = 0.01 * e - 0.02;
      double f = 0.0;  // by iteration of f = p g(eps + f / k)
      for (int i = 0; i < 500; ++i) {
        const double x = eps + f / 3e4;
        f += 0.2 * (std::max(0.0, pressure * (0.03 * x * x - 0.06 * x + 0.008)) - f);
      }
      csv += std::to_string(100 * p) + "," + std::to_string(eps) + "," +
             std::to_string(f + 5.0 * std::sin(37.0 * e * p)) + "\n";
    }
  }
  put("pam.csv", csv);
  succeed({"fit-pam", "pam.csv", "-o", "f"});
  const Json json = result("f");
  EXPECT_EQ(json.at("model"), "spring");
  EXPECT_NEAR(json.at("parameters")[3].at("value").get<double>(), 3e4, 3e3);
  EXPECT_THAT(succeed({"predict", "f/model.yaml", "pam.csv", "--inverse", "-o", "p"}), HasSubstr("pressure_Pa"));
}

TEST_F(FitTest, HelpShowsExamples) {
  for (const char* command : {"fit-friction", "fit-motor", "fit-gearbox", "fit-pam", "fit-spring", "predict"}) {
    EXPECT_THAT(succeed({command, "--help"}), HasSubstr(std::string("  simgap ") + command + " "));
  }
}

}  // namespace
}  // namespace simgap::test
