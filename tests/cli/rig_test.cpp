// Rigs and their logs as they are: constants that change with the session, an angle nobody measured, other separators,
// signs and scales, lost and doubled rows. Wrong input stands in tests/cli/broken, one file each.
#include <cmath>
#include <numbers>
#include <random>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

/// A pendulum of 0.8 kg (session b: 1.4 kg) at 0.25 m that hangs down at 0.6 rad, on a motor of 0.9 N m/A with Coulomb
/// and viscous friction.
struct Swing {
  double rate = 100.0, seconds = 120.0;
  double angle_offset = 0.6, mass_a = 0.8, mass_b = 1.4, length = 0.25;

  std::string csv(const std::string& header = "time_s,motor_current_A,motor_position_rad,session",
                  double current_factor = 1.0) const {
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    std::string text = header + "\n";
    for (int s = 0; s < 2; ++s) {
      for (int i = 0; i < static_cast<int>(0.5 * seconds * rate); ++i) {
        const double t = i / rate;
        const double angle = 1.0 * std::sin(0.9 * t) + 0.6 * std::sin(2.1 * t + s);
        const double speed = 0.9 * std::cos(0.9 * t) + 1.26 * std::cos(2.1 * t + s);
        const double acceleration = -0.81 * std::sin(0.9 * t) - 2.646 * std::sin(2.1 * t + s);
        const double mass = s == 0 ? mass_a : mass_b;
        const double torque = mass * length * (9.81 * std::sin(angle - angle_offset) + length * acceleration) +
                              std::copysign(0.2, speed) + 0.05 * speed;
        const double current = torque / 0.9 + 0.02 * normal(random);
        text += std::to_string(t) + "," + std::to_string(current_factor * current) + "," + std::to_string(angle) + "," +
                (s == 0 ? "a" : "b") + "\n";
      }
    }
    return text;
  }
};

std::string withCommas(std::string csv) {
  for (char& c : csv) c = c == ',' ? ';' : c == '.' ? ',' : c;
  return csv;
}

class RigTest : public CliTest {
 protected:
  RigTest() {
    put("log.csv", Swing().csv());
    rig("rig.yaml", "angle_offset_rad: 0.6\n");
  }
  void rig(const std::string& file, const std::string& more, const std::string& sessions = kMasses) const {
    put(file, "format: simgap/bench/1\nload: pendulum\nlength_m: 0.25\nbandwidth_Hz: 15\n" + more + sessions);
  }
  Arguments fit(const std::string& log, const std::string& directory, const Arguments& more = {}) const {
    Arguments all{"fit-friction", log, "--model", "coulomb", "--bench", "rig.yaml", "-q", "-o", directory};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Json result(const std::string& directory) const { return Json::parse(text(directory + "/result.json")); }
  /// Of a fit, or of the extended model of a diagnosis.
  double parameter(const std::string& directory, const std::string& name) const {
    const Json json = result(directory);
    for (const Json& p : json.at("parameters")) {
      if (p.at("name") == name) return p.at("value");
    }
    return std::nan("");
  }
  static constexpr const char* kMasses = "sessions: {a: {mass_kg: 0.8}, b: {mass_kg: 1.4}}\n";
};

TEST_F(RigTest, MassesOfEachSessionGiveTheTorqueConstant) {
  succeed(fit("log.csv", "f"));
  EXPECT_NEAR(parameter("f", "k_a"), 0.9, 0.01);
  EXPECT_NEAR(parameter("f", "tau_c"), 0.2, 0.01);
  succeed({"predict", "f/model.yaml", "log.csv", "--bench", "rig.yaml", "-o", "p"});
  EXPECT_LT(result("p").at("rms_error").get<double>(), 0.03);  // the noise has 0.02 A
}

TEST_F(RigTest, DiagnoseFitsTheAngle) {
  rig("fit.yaml", "angle_offset_rad: fit\n");
  succeed(
      {"diagnose", "coulomb", "--log", "log.csv", "--bench", "fit.yaml", "--effects", "current-bias", "-q", "-o", "d"});
  EXPECT_LT(std::sqrt(result("d").at("baseline").at("mse").get<double>()), 0.03);
  const std::string model = text("d/model.yaml");
  const std::size_t at = model.find("angle_offset:");
  ASSERT_NE(at, std::string::npos) << model;
  EXPECT_NEAR(std::stod(model.substr(model.find("value:", at) + 6)), 0.6, 0.01);
  succeed({"predict", "d/model.yaml", "log.csv", "--bench", "fit.yaml", "-o", "p"});
  EXPECT_LT(result("p").at("rms_error").get<double>(), 0.03);
}

TEST_F(RigTest, DiagnoseFitsMassAndAngleTogether) {
  rig("fit.yaml", "mass_kg: fit\ninertia_kg_m2: fit\nangle_offset_rad: fit\n", "");
  Swing even;
  even.mass_b = even.mass_a;
  even.angle_offset = 2.6;  // far from where a search would begin without a thought
  put("even.csv", even.csv());
  succeed({"diagnose", "coulomb", "--log", "even.csv", "--bench", "fit.yaml", "--effects", "current-bias", "-q", "-o",
           "d"});
  EXPECT_LT(std::sqrt(result("d").at("baseline").at("mse").get<double>()), 0.03);
}

TEST_F(RigTest, AFittedMassOfNothingIsNamedAsAWrongAngle) {
  rig("wrong.yaml", "mass_kg: fit\ninertia_kg_m2: 0.02\nangle_offset_rad: 3.7\n", "");
  const std::string sentence = "fitted mass at 0: the angle offset (angle_offset_rad) is probably wrong";
  const std::string table = succeed(
      {"fit-friction", "log.csv", "--model", "coulomb", "--fix", "k_a=0.9", "--bench", "wrong.yaml", "-q", "-o", "f"});
  EXPECT_THAT(table, HasSubstr(sentence));
  const ProcessResult diagnosed = simgap({"diagnose", "coulomb", "--log", "log.csv", "--bench", "wrong.yaml",
                                          "--effects", "current-bias", "-q", "-o", "d"});
  EXPECT_EQ(diagnosed.exit_code, 0) << diagnosed.err;
  EXPECT_THAT(diagnosed.err, HasSubstr(sentence));
}

TEST_F(RigTest, SeparatorsAndDecimalCommasChangeNothing) {
  put("semicolons.csv", withCommas(text("log.csv")));
  succeed(fit("log.csv", "f"));
  succeed(fit("semicolons.csv", "s"));
  EXPECT_EQ(result("f").at("parameters"), result("s").at("parameters"));
}

TEST_F(RigTest, AFactorTurnsAndScalesAColumn) {
  put("raw.csv", Swing().csv("time_s,drive_output,motor_position_rad,session", -1000.0));
  succeed(fit("log.csv", "f"));
  const Arguments map{"--map", "motor_current_A=drive_output*-0.001"};
  succeed(fit("raw.csv", "s", map));
  EXPECT_NEAR(parameter("s", "k_a"), parameter("f", "k_a"), 1e-4);
  Arguments diagnosis{"diagnose",  "coulomb",      "--log", "raw.csv", "--bench", "rig.yaml",
                      "--effects", "current-bias", "-q",    "-o",      "d"};
  diagnosis.insert(diagnosis.end(), map.begin(), map.end());
  succeed(diagnosis);
  Arguments prediction{"predict", "s/model.yaml", "raw.csv", "--bench", "rig.yaml", "-o", "p"};
  prediction.insert(prediction.end(), map.begin(), map.end());
  succeed(prediction);
  EXPECT_LT(result("p").at("rms_error").get<double>(), 0.03);
  expectRefused(fit("raw.csv", "x", {"--map", "motor_current_A=drive_output*0"}), 2, "--map: found the factor 0");
  expectRefused(fit("raw.csv", "x", {"--map", "motor_current_A=drive_output*-0,001"}), 3,
                "raw.csv:1: found no column drive_output*-0,001");
}

TEST_F(RigTest, AFewBadRowsAreLeftOutAndSaid) {
  std::string log = text("log.csv");
  const auto spoil = [&](const std::string& begin, const std::string& other) {
    const std::size_t at = log.find("\n" + begin) + 1;
    ASSERT_NE(at, 0u) << begin;
    log.replace(at, log.find('\n', at) - at, other);
  };
  spoil("3.000000,", "2.990000,0.1,0.2,a");  // repeats
  spoil("5.000000,", "1.000000,0.1,0.2,a");  // goes back
  spoil("7.000000,", "7.000000,,0.2,a");
  spoil("8.000000,", "8.000000,nan,0.2,a");
  put("spoilt.csv", log);
  const std::string table = unwrapped(succeed(fit("spoilt.csv", "f")));
  EXPECT_THAT(table, HasSubstr("spoilt.csv: rows were left out: motor_current_A has no number in 2 rows; time repeats "
                               "or goes back in 2 rows"));
  EXPECT_EQ(countOf(table, "rows were left out:"), 1u);
  EXPECT_NEAR(parameter("f", "k_a"), 0.9, 0.01);
  succeed({"diagnose", "coulomb", "--log", "spoilt.csv", "--bench", "rig.yaml", "--effects", "current-bias", "-q", "-o",
           "d"});
  const Json faults = result("d").at("faults");
  ASSERT_GE(faults.size(), 2u);
  EXPECT_EQ(faults[0].at("channel"), "motor_current_A");
  EXPECT_EQ(faults[0].at("rows"), 2);
  EXPECT_EQ(faults[1].at("channel"), "time");
  EXPECT_NE(result("d").at("verdict"), "data-fault");
  EXPECT_EQ(simgap({"predict", "f/model.yaml", "spoilt.csv", "--bench", "rig.yaml", "-o", "p"}).exit_code, 0);
}

class BrokenRigTest : public CliTest {
 protected:
  BrokenRigTest() {
    for (const std::string& name : entries(sourceFile("tests/cli/broken")))
      put(name, readText(sourceFile("tests/cli/broken/" + name)));
  }
  /// Every command that reads such a log refuses it alike.
  void expectBroken(const std::string& log, int exit_code, const std::string& sentence,
                    const Arguments& more = {}) const {
    for (Arguments command :
         {Arguments{"fit-friction", log, "--model", "coulomb"}, Arguments{"diagnose", "coulomb", "--log", log}}) {
      command.insert(command.end(), {"-q", "-o", "out"});
      command.insert(command.end(), more.begin(), more.end());
      expectRefused(command, exit_code, sentence);
    }
  }
};

TEST_F(BrokenRigTest, UnitsThatDoNotFitAreListed) {
  expectBroken("unit_unknown.csv", 3,
               "unit_unknown.csv:1: column motor_velocity_turns: unit 'turns' does not exist, expected one of rad_s, "
               "deg_s, rpm");
  expectBroken("unit_missing.csv", 3, "unit_missing.csv:1: column time: unit is missing, expected one of s, ms");
  expectBroken("unit_of_another_kind.csv", 3, "column motor_velocity_m: unit 'm' is of another kind");
  expectBroken("load_unit_unknown.csv", 3,
               "load_unit_unknown.csv:1: column external_torque_lbft: unit 'lbft' does not exist, expected one of Nm");
  expectRefused({"diagnose", "coulomb", "--log", "optional_unit_unknown.csv", "-q", "-o", "out"}, 3,
                "column temperature_F: unit 'F' does not exist, expected one of degC, C, K");
}

TEST_F(BrokenRigTest, DecimalPointsAmongDecimalCommas) {
  expectBroken(
      "decimals_mixed.csv", 3,
      "decimals_mixed.csv:4: found '0.2', and 8 of 24 rows (33.3 %) have no number in time_s, expected at most "
      "10 %");
}

TEST_F(BrokenRigTest, ClocksThatDoNotRise) {
  expectBroken("clock_backwards.csv", 3, "clock_backwards.csv:3: time goes from 5 s to 4.9 s, and 23 of 24 rows");
  expectBroken("clock_restarts.csv", 3, "(a column `session` separates runs that begin anew)");
}

TEST_F(BrokenRigTest, ChannelsWithManyGaps) {
  expectBroken("cells_empty.csv", 3,
               "cells_empty.csv:3: found an empty cell, and 5 of 24 rows (20.8 %) have no number in motor_current_A, "
               "expected at most 10 %");
}

TEST_F(BrokenRigTest, AFactorForText) {
  expectBroken("factor_of_text.csv", 3, "column motor_voltage_V is to be multiplied, expected numbers in it",
               {"--map", "motor_voltage_V=note*2"});
}

TEST_F(BrokenRigTest, SessionsOfABench) {
  const auto expectBench = [&](const std::string& bench, const std::string& sentence) {
    expectBroken("two_sessions.csv", 2, sentence, {"--bench", bench});
  };
  expectBench("session_missing.yaml", "session_missing.yaml: found no entry for session b of two_sessions.csv");
  expectBench("session_fits.yaml", "session_fits.yaml:6: sessions.a.mass_kg: found 'fit'");
  expectBench("session_without_mass.yaml", "session_without_mass.yaml:6: sessions.b: found neither mass_kg nor");
  expectBench("session_of_a_sensor.yaml", "session_of_a_sensor.yaml:3: sessions: found an unknown key");
}

}  // namespace
}  // namespace simgap::test
