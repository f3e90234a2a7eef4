#include "simgap/fit/actuators/winding_signs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "reality/motor_log.h"
#include "simgap/core/csv.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/drive_fit.h"

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

}  // namespace
}  // namespace simgap::test
