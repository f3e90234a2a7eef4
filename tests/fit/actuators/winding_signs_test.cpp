#include "simgap/fit/actuators/winding_signs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "reality/motor_log.h"
#include "simgap/core/csv.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/drive_fit.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string turnedChannel(const reality::MotorBenchLog& log) {
  return oppositeWindingSign(log.voltage, log.current, log.velocity);
}

reality::MotorBenchLog recorded(double load = 0.01) {
  return reality::simulateMotor({}, {.load = load, .current_noise = 0.05, .velocity_noise = 1.0});
}

void turn(std::vector<double>& channel) {
  for (double& value : channel) value = -value;
}

TEST(WindingSigns, NothingIsSaidOfAMotor) {
  EXPECT_THAT(turnedChannel(recorded()), IsEmpty());
  EXPECT_THAT(turnedChannel(recorded(0.05)), IsEmpty());  // that drives the motor, too
}

TEST(WindingSigns, TheTurnedChannelIsNamedWithTheFlagThatHelps) {
  reality::MotorBenchLog current = recorded(), velocity = recorded();
  turn(current.current), turn(velocity.velocity);
  EXPECT_THAT(turnedChannel(current),
              AllOf(HasSubstr("current_A has the opposite sign"), HasSubstr("--map current_A=COLUMN*-1")));
  EXPECT_THAT(turnedChannel(velocity),
              AllOf(HasSubstr("velocity_rad_s has the opposite sign"), HasSubstr("--map velocity_rad_s=COLUMN*-1")));
}

TEST(WindingSigns, AFitIsRefused) {
  reality::MotorBenchLog log = recorded();
  turn(log.current);
  const MotorLog read = readMotorLog(CsvTable::parse(log.csv(), "motor.csv"));
  try {
    fitDrive(read, {});
    ADD_FAILURE() << "a winding of nothing was delivered";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("motor.csv"), HasSubstr("current_A has the opposite sign")));
  }
}

std::string refusedMotor(const reality::MotorBenchLog& log, bool with_voltage = true, bool with_velocity = true) {
  const std::string csv = log.csv(with_voltage, true, with_velocity);
  return errorOf([&] { fitDrive(readMotorLog(CsvTable::parse(csv, "motor.csv")), {}); });
}

TEST(LoadSigns, AMotorsTurnedLoadIsNamedWithOrWithoutTheVoltage) {
  reality::MotorBenchLog log = recorded();
  turn(log.load);
  for (const bool with_voltage : {true, false}) {
    EXPECT_THAT(refusedMotor(log, with_voltage), AllOf(HasSubstr("motor.csv: load_torque_Nm has the opposite sign"),
                                                       HasSubstr("--map load_torque_Nm=COLUMN*-1")));
  }
}

TEST(LoadSigns, WithoutAVoltageTheTurnedCurrentOrVelocityIsNamed) {
  reality::MotorBenchLog current = recorded(), velocity = recorded();
  turn(current.current), turn(velocity.velocity);
  EXPECT_THAT(refusedMotor(current, false), HasSubstr("current_A has the opposite sign"));
  EXPECT_THAT(refusedMotor(velocity, false), HasSubstr("velocity_rad_s has the opposite sign"));
}

TEST(LoadSigns, WithoutAVelocityATurnedLoadOrCurrentIsRefused) {
  reality::MotorBenchLog load = recorded(), current = recorded();
  turn(load.load), turn(current.current);
  for (const reality::MotorBenchLog& log : {load, current}) {
    EXPECT_THAT(refusedMotor(log, true, false),
                AllOf(HasSubstr("does not grow with load_torque_Nm"), HasSubstr("--map load_torque_Nm=COLUMN*-1")));
  }
}

TEST(LoadSigns, ALoadThatTheCurrentDoesNotFollowIsRefused) {
  reality::MotorBenchLog log = recorded(0.0);
  for (std::size_t i = 0; i < log.load.size(); ++i) {
    log.load[i] = 1e-3 * std::sin(37.0 * static_cast<double>(i)) - 1e-5 * log.current[i];
  }
  EXPECT_THAT(refusedMotor(log), HasSubstr("does not grow with load_torque_Nm, so K_T cannot be found"));
}

TEST(LoadSigns, AGearboxsTurnedLoadIsNamed) {
  reality::MotorTruth truth;
  truth.ratio = 50.0, truth.efficiency = 0.75, truth.gear_coulomb = 0.05, truth.gear_inertia = 2e-3;
  reality::MotorBenchLog log = reality::simulateMotor(truth, {.load = 0.4, .current_noise = 0.02});
  turn(log.load);
  DriveFitOptions options;
  options.fit_motor = false, options.fit_gearbox = true, options.ratio = truth.ratio;
  options.motor = {truth.resistance, truth.inductance, truth.emf,     truth.torque,
                   truth.inertia,    truth.viscous,    truth.coulomb, 0.0};
  EXPECT_THAT(errorOf([&] { fitDrive(readMotorLog(CsvTable::parse(log.csv(), "gear.csv")), options); }),
              HasSubstr("gear.csv: load_torque_Nm has the opposite sign"));
}

}  // namespace
}  // namespace simgap::test
