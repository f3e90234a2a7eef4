#include "simgap/fit/actuators/arm_with_drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/arms.h"

namespace simgap {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(ArmWithDrive, OneMuscleGetsTheDriveAndKeepsItsSupply) {
  const ArmWithDrive target{test::exampleArm(), 2};
  Motor motor = target.arm.muscles[2].motor;
  motor.resistance *= 2.0;
  motor.supply_voltage = 1.0;  // no fit knows it
  const ArmModel with_motor = withMotor(target, motor);
  EXPECT_EQ(with_motor.muscles[2].motor.resistance, 2.0 * target.arm.muscles[2].motor.resistance);
  EXPECT_EQ(with_motor.muscles[2].motor.supply_voltage, target.arm.muscles[2].motor.supply_voltage);
  EXPECT_EQ(with_motor.muscles[1].motor, target.arm.muscles[1].motor);
  Gearbox gearbox = target.arm.muscles[2].gearbox;
  gearbox.efficiency = 0.5;
  const ArmModel with_gearbox = withGearbox(target, gearbox);
  EXPECT_EQ(with_gearbox.muscles[2].gearbox, gearbox);
  EXPECT_EQ(with_gearbox.muscles[2].motor, target.arm.muscles[2].motor);
}

TEST(ArmWithDrive, PriorsAreOfWhatIsKnown) {
  Uncertainty uncertainty;
  const auto estimate = [](const char* name, double value, double sd, bool fixed) {
    Estimate e;
    e.name = name;
    e.value = value;
    e.sd = sd;
    e.fixed = fixed;
    return e;
  };
  uncertainty.estimates = {estimate("R", 7.0, 0.25, false), estimate("L", 1e-3, 0.0, true),
                           estimate("K_T", 0.02, std::nan(""), false), estimate("another", 1.0, 1.0, false)};
  const std::string text = calibrationParameters("biceps", uncertainty);
  EXPECT_THAT(text, HasSubstr("{pattern: \"muscles.biceps.motor.resistance_ohm\", step: 0.25, prior_sd: 0.25}\n"));
  EXPECT_THAT(text, Not(HasSubstr("inductance")));
  EXPECT_THAT(text, Not(HasSubstr("torque_constant")));
  EXPECT_THAT(text, Not(HasSubstr("another")));
}

}  // namespace
}  // namespace simgap
