#include "simgap/fit/actuators/drive_fit.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "reality/motor_log.h"
#include "simgap/core/csv.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using reality::MotorBenchLog;
using reality::MotorDesign;
using reality::MotorTruth;
using reality::simulateMotor;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

MotorLog readDrive(const std::string& csv) { return readMotorLog(CsvTable::parse(csv, "motor.csv")); }

double value(const DriveFit& fit, std::string_view name) {
  for (const Estimate& e : fit.uncertainty.estimates) {
    if (e.name == name) return e.value;
  }
  ADD_FAILURE() << name;
  return 0.0;
}

void expectMotor(const DriveFit& fit, const MotorTruth& truth, double tolerance) {
  EXPECT_NEAR(value(fit, "R"), truth.resistance, tolerance * truth.resistance);
  EXPECT_NEAR(value(fit, "L"), truth.inductance, 3.0 * tolerance * truth.inductance);
  EXPECT_NEAR(value(fit, "K_E"), truth.emf, tolerance * truth.emf);
  EXPECT_NEAR(value(fit, "K_T"), truth.torque, tolerance * truth.torque);
  EXPECT_NEAR(value(fit, "J_M"), truth.inertia, tolerance * truth.inertia);
  EXPECT_NEAR(value(fit, "tau_CM"), truth.coulomb, 3.0 * tolerance * truth.coulomb);
}

TEST(MotorFit, RecoversTheTruthWithoutNoise) {
  const MotorTruth truth;
  // The reference integrates in steps of 20 us, 0.4 % of the winding's time constant.
  expectMotor(fitDrive(readDrive(simulateMotor(truth, {}).csv()), {}), truth, 3e-3);
}

TEST(MotorFit, RecoversTheTruthFromNoisyLogs) {
  const MotorTruth truth;
  const DriveFit fit =
      fitDrive(readDrive(simulateMotor(truth, {.current_noise = 0.1, .velocity_noise = 3.0}).csv()), {});
  expectMotor(fit, truth, 0.02);
  for (const Estimate& e : fit.uncertainty.estimates) {
    if (e.name == "K_T") {
      EXPECT_GT(e.sd, 0.0);
    }
  }
  ASSERT_EQ(fit.channels.size(), 2u);
  EXPECT_NEAR(fit.channels[0].rms, 3.0, 0.2);
  EXPECT_NEAR(fit.channels[1].rms, 0.1, 0.01);
}

/// 6 V and 4 V in turn, each for a second, and a second of nothing behind each: open terminals, or shorted ones.
std::string switchedMotor(bool open) {
  constexpr double kStep = 0.01, kConstant = 0.05, kResistance = 1.0, kInertia = 2e-3, kFriction = 0.02;
  std::string csv = "time_s,voltage_V,velocity_rad_s\n";
  double w = 0.0;
  for (int i = 0; i < 1600; ++i) {
    const double volts = i / 100 % 2 == 1 ? 0.0 : i / 200 % 2 == 0 ? 6.0 : 4.0;
    csv += fmt::format("{:.2f},{},{:.6f}\n", kStep * i, volts, w);
    const double current = open && volts == 0.0 ? 0.0 : (volts - kConstant * w) / kResistance;
    w = std::max(0.0, w + kStep * (kConstant * current - kFriction) / kInertia);
  }
  return csv;
}

TEST(MotorFit, SaysThatOpenTerminalsAreTakenForShortedOnes) {
  DriveFitOptions options;
  options.fixed = {{"R", 1.0}};
  const auto warnings = [&](const std::string& csv) { return fitDrive(readDrive(csv), options).warnings; };
  EXPECT_THAT(warnings(switchedMotor(true)), Contains(HasSubstr("takes the terminals for shorted")));
  // Shorted ones brake within some tenths of a second, and a log cannot tell why: it is said of them, too.
  EXPECT_THAT(warnings(switchedMotor(false)), Contains(HasSubstr("takes the terminals for shorted")));
  std::string driven = switchedMotor(true);
  for (std::size_t at = 0; (at = driven.find(",0,", at)) != std::string::npos;) driven.replace(at, 3, ",0.5,");
  EXPECT_THAT(warnings(driven), Not(Contains(HasSubstr("takes the terminals for shorted"))));
}

TEST(MotorFit, UnitsOfTheColumnsDoNotMatter) {
  MotorTruth truth;
  truth.viscous = 0.0;  // its step of differentiation has no size of its own
  const MotorBenchLog log = simulateMotor(truth, {.seconds = 3.0, .current_noise = 0.05, .velocity_noise = 1.0});
  const MotorLog si = readDrive(log.csv());
  CsvWriter other({"time_ms", "voltage_V", "current_mA", "velocity_rpm", "load_torque_mNm", "session"});
  for (std::size_t k = 0; k < log.time.size(); ++k) {
    other.add(1e3 * log.time[k]).add(log.voltage[k]).add(1e3 * log.current[k]);
    other.add(log.velocity[k] * 30.0 / std::numbers::pi).add(1e3 * log.load[k]);
    other.add(static_cast<double>(log.session[k])).endRow();
  }
  const DriveFit one = fitDrive(si, {}), two = fitDrive(readDrive(other.text()), {});
  const double torque = truth.torque * 1.0, speed = 300.0;  // of 1 A, and usual here
  for (std::size_t i = 0; i < 7; ++i) {
    const Estimate &a = one.uncertainty.estimates[i], &b = two.uncertainty.estimates[i];
    EXPECT_EQ(a.at_bound, b.at_bound) << a.name;
    EXPECT_NEAR(a.value, b.value, 1e-3 * std::max(a.upper95 - a.lower95, 0.0)) << a.name;
    EXPECT_NEAR(a.upper95, b.upper95, 1e-2 * (a.upper95 - a.lower95)) << a.name;
    if (a.name == "mu_M") {
      EXPECT_LT(a.upper95, 0.01 * torque / speed);
      EXPECT_GT(a.upper95, 0.0);
    }
  }
}

TEST(MotorFit, ALateVoltageIsFoundAndDoesNoHarm) {
  const MotorTruth truth;
  const MotorDesign design{.seconds = 3.0, .current_noise = 0.02, .velocity_noise = 1.0, .voltage_late = 1.0};
  const DriveFit fit = fitDrive(readDrive(simulateMotor(truth, design).csv()), {});
  expectMotor(fit, truth, 0.01);
  ASSERT_EQ(fit.fitted_delays.size(), 2u);
  EXPECT_EQ(fit.fitted_delays[0].channel, "voltage_V");
  EXPECT_NEAR(fit.fitted_delays[0].seconds, 1.0 / design.rate, 0.05 / design.rate);
  EXPECT_THAT(fit.warnings, Contains(HasSubstr("voltage_V comes 1")));
  EXPECT_LE(fit.uncertainty.n_effective, static_cast<double>(fit.rows));
}

TEST(MotorFit, RowsThatAreHeldOutDoNotCount) {
  const MotorBenchLog log = simulateMotor({}, {.seconds = 3.0, .current_noise = 0.05, .velocity_noise = 1.0});
  const MotorLog read_log = readDrive(log.csv());
  std::vector<bool> fitted(read_log.rows(), true);
  std::fill(fitted.begin(), fitted.begin() + 1500, false);
  const DriveFit fit = fitDrive(read_log, {}, fitted);
  EXPECT_EQ(fit.rows, read_log.rows() - 1500);
  EXPECT_LE(fit.uncertainty.n_effective, static_cast<double>(fit.rows));
}

TEST(MotorFit, ListsWhatALogWithoutAChannelCannotShow) {
  const MotorTruth truth;
  const MotorBenchLog log = simulateMotor(truth, {.current_noise = 0.02, .velocity_noise = 1.0});
  const DriveFit no_load = fitDrive(readDrive(log.csv(true, false)), {});
  EXPECT_THAT(no_load.warnings, Contains(HasSubstr("K_T is taken as K_E")));
  const DriveFit no_voltage = fitDrive(readDrive(log.csv(false)), {});
  EXPECT_THAT(no_voltage.warnings, Contains(HasSubstr("R, L and K_E cannot be found")));
  EXPECT_FALSE(no_voltage.uncertainty.estimates[0].identifiable);
  EXPECT_TRUE(std::isnan(value(no_voltage, "R")));
  EXPECT_NEAR(value(no_voltage, "K_T"), truth.torque, 0.03 * truth.torque);
  EXPECT_THAT(errorOf([&] { fitDrive(readDrive(log.csv(false, false)), {}); }), HasSubstr("only ratios"));
  EXPECT_THAT(errorOf([&] { fitDrive(readDrive(log.csv(false, true, false)), {}); }), HasSubstr("found no velocity"));
}

// K_E / J_M and K_E / mu_M are all that a winding tells of its rotor: a constant of its own came out as 0.0067 +- 1e6.
TEST(MotorFit, WithoutAVelocityOneConstantIsToldByTheLoad) {
  for (const double constant : {0.021, 0.06}) {
    MotorTruth truth;
    truth.resistance = 2.0, truth.emf = truth.torque = constant;
    const MotorBenchLog log = simulateMotor(truth, {.load = 0.02, .current_noise = 0.02});
    const DriveFit fit = fitDrive(readDrive(log.csv(true, true, false)), {});
    EXPECT_THAT(fit.warnings, Contains(HasSubstr("no velocity in the log: K_E is taken as K_T")));
    EXPECT_EQ(value(fit, "K_E"), value(fit, "K_T"));
    expectMotor(fit, truth, 0.03);
  }
}

TEST(MotorFit, WithoutAVelocityAKnownConstantIsBoth) {
  const MotorTruth truth;
  const MotorBenchLog log = simulateMotor(truth, {.load = 0.0, .current_noise = 0.02});
  const MotorLog unloaded = readDrive(log.csv(true, false, false));
  DriveFitOptions options;
  options.fixed["K_T"] = truth.torque;
  const DriveFit fit = fitDrive(unloaded, options);
  EXPECT_THAT(fit.warnings, Contains(HasSubstr("no velocity in the log: K_E is taken as K_T")));
  EXPECT_EQ(value(fit, "K_E"), truth.torque);
  expectMotor(fit, truth, 0.03);
  EXPECT_THAT(errorOf([&] { fitDrive(unloaded, {}); }), HasSubstr("neither a velocity nor a load torque"));
}

TEST(MotorFit, BoundsOfTiedConstantsHoldForBoth) {
  const MotorLog log = readDrive(simulateMotor({}, {.seconds = 2.0, .current_noise = 0.02}).csv(true, true, false));
  DriveFitOptions options;
  options.bounds["K_T"] = {0.03, 0.1};
  EXPECT_GE(value(fitDrive(log, options), "K_E"), 0.03);
  options.bounds["K_E"] = {0.01, 0.02};
  EXPECT_THAT(errorOf([&] { fitDrive(log, options); }), HasSubstr("have nothing in common"));
}

TEST(MotorFit, ASlipOfUnitsIsSeenInTheConstants) {
  MotorBenchLog log =
      simulateMotor({}, {.seconds = 3.0, .load = 0.005, .voltage = 5.0, .current_noise = 0.02, .velocity_noise = 1.0});
  EXPECT_THAT(fitDrive(readDrive(log.csv()), {}).warnings, Not(Contains(HasSubstr("times K_E"))));
  for (double& velocity : log.velocity) velocity *= 180.0 / std::numbers::pi;
  EXPECT_THAT(fitDrive(readDrive(log.csv()), {}).warnings,
              Contains(HasSubstr("times K_E, in SI units a motor's are about one: velocity_rad_s looks like degrees")));
}

/// A motor of 0.8 ohm, 1 mH, 0.02 Vs under steps of voltage and of a load that the log lacks, in Euler steps of 5 us:
/// 0.4 % of the winding's time constant. Columns as a bench writes them, at 500 Hz.
std::string logUnderUnloggedLoad(double load) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> normal;
  constexpr double kStep = 5e-6, kInertia = 6e-6;
  CsvWriter log({"time_s", "session", "voltage_V", "current_A", "velocity_rad_s"});
  for (int session = 0; session < 2; ++session) {
    double i = 0.0, w = 0.0, voltage = 0.0, torque = 0.0;
    for (int row = 0; row < 2000; ++row) {
      if (row % 200 == 0) voltage = 10.0 * uniform(random);
      if (row % 350 == 0) torque = load * uniform(random);
      log.add(2e-3 * row).add(static_cast<double>(session)).add(voltage);
      log.add(i + 0.02 * normal(random)).add(w + 0.5 * normal(random)).endRow();
      for (int k = 0; k < 400; ++k) {
        const double hold = 0.002 * kStep / kInertia, free = w + kStep / kInertia * (0.02 * i - 2e-6 * w - torque);
        i += kStep / 1e-3 * (voltage - 0.8 * i - 0.02 * w);
        w = std::abs(free) <= hold ? 0.0 : free - std::copysign(hold, free);
      }
    }
  }
  return log.text();
}

const Estimate& estimate(const DriveFit& fit, std::string_view name) {
  return *std::ranges::find(fit.uncertainty.estimates, name, &Estimate::name);
}

TEST(MotorFit, AnUnloggedLoadLeavesTheWindingAlone) {
  const DriveFit fit = fitDrive(readDrive(logUnderUnloggedLoad(0.008)), {});
  for (const auto& [name, truth] : {std::pair{"R", 0.8}, std::pair{"K_E", 0.02}}) {
    const Estimate& found = estimate(fit, name);
    EXPECT_NEAR(found.value, truth, std::min(3.0 * found.sd, 0.01 * truth)) << name;
  }
  EXPECT_NEAR(value(fit, "L"), 1e-3, 5e-5);
  EXPECT_EQ(value(fit, "K_T"), value(fit, "K_E"));
  for (const char* name : {"J_M", "mu_M", "tau_CM"}) {
    EXPECT_TRUE(std::isnan(value(fit, name))) << name;
    EXPECT_FALSE(estimate(fit, name).identifiable) << name;
  }
  EXPECT_EQ(fit.extent, DriveExtent::kWinding);
  EXPECT_THAT(fit.warnings, Contains(HasSubstr("something acts on the motor that the log does not hold")));
  EXPECT_THAT(fit.warnings, Not(Contains(HasSubstr("voltage_V comes"))));
  EXPECT_THAT(fit.warnings, Not(Contains(HasSubstr("hold only if nothing loaded"))));
  ASSERT_EQ(fit.channels.size(), 1u);
  EXPECT_NEAR(fit.channels[0].rms, 0.02, 0.004);  // and K_E / R times the velocity's noise
}

// A refit without held-out rows has the channels of the fit that it judges.
TEST(MotorFit, AStatedExtentIsKept) {
  DriveFitOptions whole;
  whole.extent = DriveExtent::kWhole;
  EXPECT_EQ(fitDrive(readDrive(logUnderUnloggedLoad(0.008)), whole).channels.size(), 2u);
}

TEST(MotorFit, WithoutAnyLoadTheMechanicsIsFound) {
  const DriveFit fit = fitDrive(readDrive(logUnderUnloggedLoad(0.0)), {});
  EXPECT_EQ(fit.extent, DriveExtent::kWhole);
  EXPECT_NEAR(value(fit, "J_M"), 6e-6, 6e-8);
  EXPECT_NEAR(value(fit, "tau_CM"), 0.002, 4e-5);
  EXPECT_THAT(fit.warnings, Contains(HasSubstr("J_M, mu_M and tau_CM hold only if nothing loaded the motor")));
  EXPECT_THAT(fit.warnings, Not(Contains(HasSubstr("something acts"))));
}

TEST(GearboxFit, RecoversTheTruthWithAndWithoutSpeed) {
  MotorTruth truth;
  truth.ratio = 50.0;
  truth.efficiency = 0.75;
  truth.gear_coulomb = 0.05;
  truth.gear_viscous = 0.004;
  truth.gear_inertia = 2e-3;
  MotorDesign design;
  design.load = 0.4;
  design.current_noise = 0.02;
  design.velocity_noise = 1.0;
  const MotorBenchLog log = simulateMotor(truth, design);
  DriveFitOptions options;
  options.fit_motor = false;
  options.fit_gearbox = true;
  options.ratio = truth.ratio;
  options.motor = {truth.resistance, truth.inductance, truth.emf,     truth.torque,
                   truth.inertia,    truth.viscous,    truth.coulomb, 0.0};
  for (const bool with_speed : {true, false}) {
    const DriveFit fit = fitDrive(readDrive(log.csv(true, true, with_speed)), options);
    EXPECT_NEAR(value(fit, "eta"), truth.efficiency, 0.03) << with_speed;
    EXPECT_NEAR(value(fit, "tau_CG"), truth.gear_coulomb, 0.02) << with_speed;
    EXPECT_NEAR(value(fit, "J_G"), truth.gear_inertia, 0.2e-3) << with_speed;
  }
  EXPECT_THAT(errorOf([&] { fitDrive(readDrive(log.csv(true, false)), options); }),
              HasSubstr("load torque is missing"));
  MotorBenchLog output = log;
  for (double& velocity : output.velocity) velocity /= truth.ratio;
  EXPECT_THAT(errorOf([&] { fitDrive(readDrive(output.csv()), options); }),
              HasSubstr("with the motor's R and K_E: it looks like the output's, expected the motor's"));
}

}  // namespace
}  // namespace simgap::test
