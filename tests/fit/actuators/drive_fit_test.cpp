#include "simgap/fit/actuators/drive_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "reality/motor_log.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using reality::MotorBenchLog;
using reality::MotorDesign;
using reality::MotorTruth;
using reality::simulateMotor;
using ::testing::Contains;
using ::testing::HasSubstr;

MotorLog read(const std::string& csv) { return readMotorLog(CsvTable::parse(csv, "motor.csv")); }

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
  expectMotor(fitDrive(read(simulateMotor(truth, {}).csv()), {}), truth, 3e-3);
}

TEST(MotorFit, RecoversTheTruthFromNoisyLogs) {
  const MotorTruth truth;
  const DriveFit fit = fitDrive(read(simulateMotor(truth, {.current_noise = 0.1, .velocity_noise = 3.0}).csv()), {});
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

TEST(MotorFit, ListsWhatALogWithoutAChannelCannotShow) {
  const MotorTruth truth;
  const MotorBenchLog log = simulateMotor(truth, {.current_noise = 0.02, .velocity_noise = 1.0});
  const DriveFit no_load = fitDrive(read(log.csv(true, false)), {});
  EXPECT_THAT(no_load.warnings, Contains(HasSubstr("K_T is taken as K_E")));
  const DriveFit no_voltage = fitDrive(read(log.csv(false)), {});
  EXPECT_THAT(no_voltage.warnings, Contains(HasSubstr("R, L and K_E cannot be found")));
  EXPECT_FALSE(no_voltage.uncertainty.estimates[0].identifiable);
  EXPECT_TRUE(std::isnan(value(no_voltage, "R")));
  EXPECT_NEAR(value(no_voltage, "K_T"), truth.torque, 0.03 * truth.torque);
  EXPECT_THAT(errorOf([&] { fitDrive(read(log.csv(false, false)), {}); }), HasSubstr("only ratios"));
  EXPECT_THAT(errorOf([&] { fitDrive(read(log.csv(false, true, false)), {}); }), HasSubstr("found no velocity"));
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
    const DriveFit fit = fitDrive(read(log.csv(true, true, with_speed)), options);
    EXPECT_NEAR(value(fit, "eta"), truth.efficiency, 0.03) << with_speed;
    EXPECT_NEAR(value(fit, "tau_CG"), truth.gear_coulomb, 0.02) << with_speed;
    EXPECT_NEAR(value(fit, "J_G"), truth.gear_inertia, 0.2e-3) << with_speed;
  }
  EXPECT_THAT(errorOf([&] { fitDrive(read(log.csv(true, false)), options); }), HasSubstr("load torque is missing"));
}

}  // namespace
}  // namespace simgap::test
