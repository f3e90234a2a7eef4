// `simgap diagnose` on logs of motors, gearboxes and pneumatic muscles with a secret, and on simulated versions of the
// experiments of 002 and 003.
#include <fmt/format.h>

#include <cmath>
#include <random>
#include <sstream>

#include "cli/cli_fixture.h"
#include "reality/friction_log.h"
#include "reality/motor_log.h"
#include "reality/pam_rig.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

class DiagnoseActuators : public CliTest {
 protected:
  Json ask(const std::string& model, const std::string& csv, const Arguments& more = {}) const {
    put("log.csv", csv);
    return diagnosis(model, more);
  }
  static reality::MotorDesign bench(std::uint64_t seed) {
    reality::MotorDesign design;
    design.seconds = 10.0;
    design.sessions = 3;
    design.current_noise = 0.02;
    design.velocity_noise = 0.2;
    design.seed = seed;
    return design;
  }
  Json askMuscle(const reality::PamTruth& truth, std::uint64_t seed) const {
    reality::PamDesign design;
    design.seed = seed;
    return ask("pam", reality::recordPam(truth, design).csv());
  }
  Json askMotor(const reality::MotorTruth& truth, std::uint64_t seed) const {
    return ask("motor", reality::simulateMotor(truth, bench(seed)).csv());
  }
  /// A rotor and its load are slow beside a winding.
  static reality::MotorDesign gearboxBench(std::uint64_t seed) {
    reality::MotorDesign design = bench(seed);
    design.rate = 500.0;
    return design;
  }
  Json askGearbox(const reality::MotorTruth& truth, std::uint64_t seed) const {
    return ask("gearbox", reality::simulateMotor(truth, gearboxBench(seed)).csv());
  }
  static double valueOf(const Json& result, const std::string& parameter) {
    for (const Json& p : result.at("causes").at(0).at("parameters")) {
      if (p.at("name") == parameter) return p.at("value");
    }
    throw std::runtime_error("no parameter " + parameter);
  }
  static bool alone(const Json& result, const std::string& effect) {
    return result.at("verdict") == "cause-found" && result.at("causes").size() == 1 &&
           result.at("causes")[0].at("effect") == effect;
  }
};

TEST_F(DiagnoseActuators, AreSilentWhereNothingIsHidden) {
  for (const std::uint64_t seed : {1, 2}) {
    const Json muscle = askMuscle({}, seed), motor = askMotor({}, seed), gearbox = askGearbox({}, seed);
    EXPECT_EQ(muscle.at("verdict"), "nothing-found") << muscle.at("sentence");
    EXPECT_EQ(motor.at("verdict"), "nothing-found") << motor.at("sentence");
    EXPECT_EQ(gearbox.at("verdict"), "nothing-found") << gearbox.at("sentence");
    EXPECT_GE(muscle.at("detectable").size(), 4u);
  }
}

// 002: the model without a tendon is wrong, and the more so the larger the force.
TEST_F(DiagnoseActuators, FindTheTendonOf002) {
  reality::PamTruth truth;
  truth.tendon = 20000.0;
  const Json result = askMuscle(truth, 3);
  ASSERT_TRUE(alone(result, "tendon-compliance")) << result.at("sentence");
  EXPECT_NEAR(1.0 / valueOf(result, "compliance"), 20000.0, 1000.0);
  const std::string model = text("d/model.yaml");
  EXPECT_NE(model.find("law: spring"), std::string::npos) << model;
  succeed({"predict", "d/model.yaml", "log.csv", "-q", "-o", "p"});
  EXPECT_LT(Json::parse(text("p/result.json")).at("rms_error").get<double>(), 6.0);
  succeed({"diagnose", "d/model.yaml", "--log", "log.csv", "-q", "-o", "again"});
  EXPECT_EQ(Json::parse(text("again/result.json")).at("verdict"), "nothing-found");
}

TEST_F(DiagnoseActuators, NameWhatIsWrongWithAMuscle) {
  reality::PamTruth hysteresis, ends, bias;
  hysteresis.braid_friction = 3e-5;
  ends.ends = 0.4;
  ends.ends_pressure = 5e4;
  bias.force_offset = 15.0;
  EXPECT_TRUE(alone(askMuscle(hysteresis, 4), "contraction-hysteresis"));
  EXPECT_TRUE(alone(askMuscle(ends, 5), "end-effect"));
  const Json force = askMuscle(bias, 6);
  ASSERT_TRUE(alone(force, "force-bias"));
  EXPECT_NEAR(valueOf(force, "f0"), 15.0, 1.5);
  succeed({"predict", "d/model.yaml", "log.csv", "-q", "-o", "p"});
  EXPECT_LT(Json::parse(text("p/result.json")).at("rms_error").get<double>(), 6.0);
}

// What no catalogue had took another name: end-effect, force-bias.
TEST_F(DiagnoseActuators, NameTheRubberOfAMuscle) {
  reality::PamTruth wall, creep;
  wall.wall = 400.0;
  creep.creep = 0.08;
  const Json stiff = askMuscle(wall, 21);
  ASSERT_TRUE(alone(stiff, "wall-stiffness")) << stiff.at("sentence");
  EXPECT_NEAR(valueOf(stiff, "k_w"), 400.0, 60.0);
  const Json slow = askMuscle(creep, 22);
  ASSERT_TRUE(alone(slow, "muscle-creep")) << slow.at("sentence");
  EXPECT_NEAR(valueOf(slow, "share"), 0.08, 0.02);
}

// It had been friction of the braid, at a size that could as well have been none.
TEST_F(DiagnoseActuators, NameTheDragOfAMuscle) {
  for (const double drag : {5.0, 15.0}) {
    reality::PamTruth truth;
    truth.drag = drag;
    const Json result = askMuscle(truth, 26);
    ASSERT_TRUE(alone(result, "contraction-damping")) << result.at("sentence");
    EXPECT_NEAR(valueOf(result, "c") * 0.05, drag, 0.25 * drag);
  }
}

// Rubber creeps by the logarithm of time: with one relaxation time half of a share was found, and a bias of the force.
TEST_F(DiagnoseActuators, NameARubberThatCreepsOnManyTimeScales) {
  reality::PamTruth truth;
  truth.creep_log = 0.012;
  const Json result = askMuscle(truth, 23);
  EXPECT_TRUE(alone(result, "muscle-creep")) << result.at("sentence");
  EXPECT_EQ(valueOf(result, "decades"), 2.0);
}

// A pressure that is measured before a hose: the tendon's compliance was named for it.
TEST_F(DiagnoseActuators, NameTheHoseBetweenSensorAndMuscle) {
  reality::PamTruth truth;
  truth.hose_seconds = 0.15;
  const Json hose = askMuscle(truth, 24);
  ASSERT_TRUE(alone(hose, "pressure-lag")) << hose.at("sentence");
  EXPECT_NEAR(valueOf(hose, "tau"), 0.15, 0.01);
  succeed({"predict", "d/model.yaml", "log.csv", "-q", "-o", "p"});
  EXPECT_LT(Json::parse(text("p/result.json")).at("rms_error").get<double>(), 6.0);
}

// Between two rows no lag says how a step of the pressure went: a creep of one row and a half stood for that.
TEST_F(DiagnoseActuators, KnowNoCreepWithinTwoRows) {
  std::mt19937_64 random(9);
  std::normal_distribution<> normal;
  std::uniform_real_distribution<> level(0.6e5, 5e5);
  std::string log = "time_s,pressure_Pa,contraction,force_N\n";
  double pressure = 2e5, inside = pressure;
  for (int i = 0; i < 8000; ++i) {
    const double t = 0.01 * i, x = 0.12 + 0.07 * std::sin(0.314 * t) + 0.03 * std::sin(1.445 * t + 1.0);
    if (i % 200 == 0) pressure = level(random);
    inside += (1.0 - std::exp(-0.01 / 0.12)) * (pressure - inside);
    const double read = pressure + 300.0 * normal(random);
    const double force = inside * (3.0e-3 * x * x - 5.5e-3 * x + 1.5e-3) + normal(random);
    log += fmt::format("{:.2f},{:.1f},{:.5f},{:.3f}\n", t, read, x, force);
  }
  const Json result = ask("pam", log, {"--effects", "pressure-lag,muscle-creep"});
  EXPECT_TRUE(alone(result, "pressure-lag")) << result.at("sentence");
}

// Beside a cause, what is far above the noise and follows no channel was "nothing that the logged channels show".
TEST_F(DiagnoseActuators, SayWhatIsLeftBesideACause) {
  reality::PamTruth truth;
  truth.tendon = 6000.0;
  truth.hose_seconds = 0.15;
  reality::PamDesign design;
  design.seed = 25;
  const Json result = ask("pam", reality::recordPam(truth, design).csv(), {"--effects", "tendon-compliance"});
  ASSERT_TRUE(alone(result, "tendon-compliance")) << result.at("sentence");
  const double left =
      result.at("extended").at("mse_heldout").get<double>() - result.at("baseline").at("noise_floor").get<double>();
  const double whole = result.at("baseline").at("mse_heldout").get<double>();
  EXPECT_GT(left / whole, 0.05);
  EXPECT_NEAR(result.at("left_over").at("share_percent").get<double>(), 100.0 * left / whole, 1.0);
  EXPECT_THAT(result.at("sentence").get<std::string>(), ::testing::HasSubstr("times the noise"));
  EXPECT_THAT(result.at("next_experiment").get<std::string>(), ::testing::HasSubstr("no logged channel explains it"));
}

TEST_F(DiagnoseActuators, NameTheOffsetOfAWindingsSensor) {
  reality::MotorTruth offset;
  offset.current_offset = 0.2;
  const Json result = askMotor(offset, 23);
  ASSERT_TRUE(alone(result, "voltage-bias")) << result.at("sentence");
  EXPECT_NEAR(valueOf(result, "V_0"), -0.2 * offset.resistance, 0.02);
}

TEST_F(DiagnoseActuators, SayWhenNoLogCanTellTwoCausesApart) {
  reality::PamTruth truth;
  truth.bladder = 2e4;
  const Json result = askMuscle(truth, 7);
  EXPECT_EQ(result.at("verdict"), "ambiguous");
  std::vector<std::string> group = result.at("causes")[0].at("ambiguous_with");
  group.push_back(result.at("causes")[0].at("effect"));
  EXPECT_THAT(group, ::testing::UnorderedElementsAre("pressure-threshold", "pressure-bias"));
  EXPECT_NEAR(valueOf(result, "p0"), 2e4, 1e3);
  reality::PamTruth ends;  // over most of the pressures what a wall of rubber does, too
  ends.ends = 0.2;
  const Json either = askMuscle(ends, 5);
  EXPECT_EQ(either.at("verdict"), "ambiguous");
  EXPECT_THAT(either.at("causes")[0].dump(),
              ::testing::AllOf(::testing::HasSubstr("\"end-effect\""), ::testing::HasSubstr("\"wall-stiffness\"")));
  truth.bladder = 0.0;
  truth.sensor_offset = -2e4;  // more force than the reading explains: no bladder does that
  EXPECT_TRUE(alone(askMuscle(truth, 8), "pressure-bias"));
}

TEST_F(DiagnoseActuators, SayUnexplainedForAMuscleThatBreathes) {
  reality::PamTruth truth;
  truth.breathing = 0.04;
  const Json result = askMuscle(truth, 9);
  EXPECT_EQ(result.at("verdict"), "unexplained") << result.at("sentence");
  EXPECT_EQ(result.at("left_over").at("channels")[0].at("channel"), "humidity_percent");
}

// Rubber lets go of a force; what goes on rising after a rise is something else, and was called creep.
TEST_F(DiagnoseActuators, DoNotCallWhatGoesOnRisingCreep) {
  reality::PamTruth truth;
  truth.creep = -0.12;
  const Json result = askMuscle(truth, 9);
  for (const Json& cause : result.at("causes")) EXPECT_NE(cause.at("effect"), "muscle-creep") << result.at("sentence");
}

// An eccentric pinion turns with the motor: its angle was taken for the joint's, and the ripple for a weight.
TEST_F(DiagnoseActuators, DoNotTakeTheMotorsAngleForTheJoints) {
  const CsvTable log = CsvTable::parse(reality::simulateMotor({}, gearboxBench(21)).csv(), "log.csv");
  const std::vector<double> time = log.quantity("time", "s"), speed = log.quantity("velocity", "rad_s");
  std::string csv = "time_s,motor_current_A,motor_velocity_rad_s,motor_position_rad,external_torque_Nm,session\n";
  const std::vector<double> current = log.quantity("current", "A"), load = log.quantity("load_torque", "Nm"),
                            session = log.quantity("session", "");
  double angle = 0.0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (i > 0 && session[i] == session[i - 1]) angle += 0.5 * (time[i] - time[i - 1]) * (speed[i] + speed[i - 1]);
    csv += fmt::format("{:.6f},{:.6g},{:.6g},{:.6g},{:.6g},{}\n", time[i], current[i] + 0.1 * std::sin(angle), speed[i],
                       angle, load[i], session[i]);
  }
  const Json result = ask("gearbox", csv);
  for (const Json& cause : result.at("causes")) EXPECT_NE(cause.at("effect"), "joint-gravity") << result.at("sentence");
  const auto reason = [](const Json& answer) {
    for (const Json& other : answer.at("not_testable")) {
      if (other.at("effect") == "joint-gravity") return other.at("reason").get<std::string>();
    }
    return std::string("tested");
  };
  EXPECT_THAT(reason(result), testing::HasSubstr("joint_position_rad"));
  EXPECT_EQ(reason(ask("gearbox", csv, {"--ratio", "16", "--effects", "joint-gravity"})), "tested");
}

TEST_F(DiagnoseActuators, NameWhatIsWrongWithAWinding) {
  reality::MotorTruth brushes, warm;
  brushes.brush_drop = 0.6;
  warm.heating = 0.6;
  const Json drop = askMotor(brushes, 10), heat = askMotor(warm, 11);
  EXPECT_TRUE(alone(drop, "brush-drop")) << drop.at("sentence");
  ASSERT_TRUE(alone(heat, "winding-heating")) << heat.dump(1);
  // The last one's extended model: `predict` gives the winding's voltage, `fit-motor` fits it to the log again.
  succeed({"predict", "d/model.yaml", "log.csv", "-q", "-o", "p"});
  EXPECT_LT(Json::parse(text("p/result.json")).at("rms_error").get<double>(),
            1.2 * std::sqrt(heat.at("extended").at("mse").get<double>()));
  succeed({"fit-motor", "log.csv", "--model", "d/model.yaml", "-q", "-o", "refit"});
  const Json refit = Json::parse(text("refit/result.json"));
  EXPECT_NEAR(refit.at("mse").get<double>(), heat.at("extended").at("mse").get<double>(),
              0.1 * refit.at("mse").get<double>());
  EXPECT_TRUE(alone(heat, "winding-heating")) << heat.at("sentence");
}

/// The log with the temperature of a winding that warms up with its losses within `seconds`.
std::string withTemperature(const reality::MotorBenchLog& log, double seconds) {
  std::istringstream rows(log.csv());
  std::string line, csv;
  std::getline(rows, line);
  csv = line + ",temperature_degC\n";
  double warm = 0.0;
  for (std::size_t i = 0; std::getline(rows, line); ++i) {
    const bool begins = i == 0 || log.session[i] != log.session[i - 1];
    warm = begins ? 0.0 : warm + (log.time[i] - log.time[i - 1]) * (log.current[i] * log.current[i] - warm) / seconds;
    csv += fmt::format("{},{:.2f}\n", line, 20.0 + 10.0 * warm);
  }
  return csv;
}

// Its time to warm up was printed, too, as if it were known: where it had begun, to 0 s.
TEST_F(DiagnoseActuators, SayOfAWindingsHeatingWhatTheTemperatureLeavesOpen) {
  reality::MotorTruth warm;
  warm.heating = 0.6;
  const Json heat = ask("motor", withTemperature(reality::simulateMotor(warm, bench(11)), warm.heating_seconds));
  ASSERT_TRUE(alone(heat, "winding-heating")) << heat.at("sentence");
  const Json& parameters = heat.at("causes")[0].at("parameters");
  ASSERT_EQ(parameters.size(), 1u) << parameters;
  EXPECT_EQ(parameters[0].at("name"), "dR");
}

TEST_F(DiagnoseActuators, NameWhatIsWrongWithAGearbox) {
  reality::MotorTruth loss, ripple;
  loss.load_loss = 0.25;
  ripple.ripple = 0.0015;
  const Json lossy = askGearbox(loss, 12);
  ASSERT_TRUE(alone(lossy, "load-dependent-efficiency")) << lossy.at("sentence");
  EXPECT_NEAR(valueOf(lossy, "e"), 0.25, 0.05);
  reality::MotorDesign slow = gearboxBench(13);  // a fast rotor's inertia smooths a ripple away
  slow.voltage = 3.0;
  const Json rippled = ask("gearbox", reality::simulateMotor(ripple, slow).csv());
  ASSERT_TRUE(alone(rippled, "gearbox-ripple")) << rippled.at("sentence") << rippled.at("candidates");
  EXPECT_NEAR(valueOf(rippled, "r"), 2.0, 0.01);
  reality::MotorTruth loose;
  loose.play = 4.0;
  slow.seed = 14;
  // While the rotor coasts through the play it is no gearbox at all, and small causes may be read into that after it.
  const Json played = ask("gearbox", reality::simulateMotor(loose, slow).csv(), {"--max-causes", "1"});
  ASSERT_EQ(played.at("verdict"), "cause-found") << played.at("sentence") << played.at("candidates");
  EXPECT_EQ(played.at("causes")[0].at("effect"), "backlash");
  EXPECT_GT(played.at("causes")[0].at("gain_heldout_percent").get<double>(), 70.0);
  EXPECT_NEAR(valueOf(played, "play"), 4.0, 0.3);
}

TEST_F(DiagnoseActuators, TellBristlesOfAGearFromPlay) {
  reality::MotorTruth soft;
  soft.bristle_travel = 4.0;
  reality::MotorDesign slow = gearboxBench(15);
  slow.voltage = 3.0;
  const Json bent = ask("gearbox", reality::simulateMotor(soft, slow).csv());
  ASSERT_TRUE(alone(bent, "presliding-hysteresis")) << bent.at("sentence") << bent.at("candidates");
  EXPECT_NEAR(valueOf(bent, "x_s"), 4.0, 0.4);
}

TEST_F(DiagnoseActuators, SayThatAWindingsCurrentIsTurned) {
  reality::MotorBenchLog log = reality::simulateMotor({}, bench(16));
  for (double& current : log.current) current = -current;
  const Json turned = ask("motor", log.csv());
  ASSERT_EQ(turned.at("verdict"), "data-fault") << turned.at("sentence");
  EXPECT_NE(turned.at("faults")[0].at("sentence").get<std::string>().find("current_A has the opposite sign"),
            std::string::npos);
}

// 003: friction without load on the sliding part alone (variant A) is worth some 15 %, and is no static offset.
TEST_F(DiagnoseActuators, FindTheOffsetOf003) {
  reality::FrictionTruth truth;
  truth.sliding_offset = 1.2;
  truth.noise = 0.87;
  reality::LogDesign design;
  design.rows = 10000;
  design.sessions = 20;
  const Json result = ask("classic", reality::simulateFrictionLog(truth, design).csv());
  ASSERT_TRUE(alone(result, "coulomb-offset")) << result.at("sentence");
  EXPECT_NEAR(result.at("causes")[0].at("gain_heldout_percent").get<double>(), 15.0, 5.0);
}

}  // namespace
}  // namespace simgap::test
