// What of MJCF moves a robot or where it rests, though it looks as if it did not: margins of stops, groups that are
// switched off, limits of a control, damping of what is pulled.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "mjcf_texts.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

std::string swinging(const std::string& attributes) { return "<joint name='h'" + attributes + "/>\n" + kBall; }

/// A line from the world to the body, pulled by an actuator.
ImportedArm pulled(const std::string& tendon, const std::string& actuator) {
  return readText(robot("", swinging("") + "<site name='in' pos='0.1 0 0'/>\n",
                        "<worldbody><site name='out' pos='0 1 0'/></worldbody>\n<tendon><spatial name='t'" + tendon +
                            "><site site='in'/><site site='out'/></spatial></tendon>\n<actuator>" + actuator +
                            "</actuator>\n"));
}

TEST(MjcfEffects, AStopHoldsItsMarginBeforeTheEndOfTheRange) {
  // In radians in a file in degrees, too.
  const ImportedArm read = readText(robot("", swinging(" range='-90 90' margin='0.2'")));
  EXPECT_DOUBLE_EQ(read.model.joints[0].lower_limit, 0.2 - std::numbers::pi / 2.0);
  EXPECT_DOUBLE_EQ(read.model.joints[0].upper_limit, std::numbers::pi / 2.0 - 0.2);
  EXPECT_TRUE(hasRemark(read.remarks, "joint margin", false, "robot.xml:4"));
  const ImportedArm wide = readText(robot("", swinging(" range='-10 10' margin='0.2'")));
  EXPECT_DOUBLE_EQ(wide.model.joints[0].upper_limit, std::numbers::pi / 18.0);
  EXPECT_TRUE(hasRemark(wide.remarks, "joint margin", true, "robot.xml:4"));
  EXPECT_FALSE(hasRemark(readText(robot("", swinging(" margin='0.2'"))).remarks, "joint margin", false, "robot.xml:4"))
      << "without a range it does nothing";
}

TEST(MjcfEffects, AnActuatorOfAGroupThatIsSwitchedOffPullsNothing) {
  const ImportedArm read =
      readText(robot("<option actuatorgroupdisable='1 3'/>\n", swinging(""),
                     "<actuator>\n<motor joint='h'/>\n<motor name='off' joint='h' group='3'/>\n</actuator>\n"));
  ASSERT_EQ(read.model.tendons.size(), 1U);
  EXPECT_EQ(read.model.tendons[0].name, "h");
  EXPECT_TRUE(hasRemark(read.remarks, "motor (actuator)", false, "robot.xml:11"));
}

TEST(MjcfEffects, LimitsOfAControlMatterWhereTheyLeaveOutZero) {
  const auto matters = [](const std::string& range) {
    const ImportedArm read = readText(
        robot("", swinging(""), "<actuator><position joint='h' kp='3' ctrlrange='" + range + "'/></actuator>\n"));
    return hasRemark(read.remarks, "position ctrlrange", true, "robot.xml:8");
  };
  EXPECT_TRUE(matters("0.4 1"));
  EXPECT_TRUE(matters("-1 -0.4"));
  EXPECT_FALSE(matters("-1 0"));
}

TEST(MjcfEffects, TheCordDampsWhatDampsThePulledTendon) {
  const ImportedArm servo = pulled(" damping='300'", "<position tendon='t' kp='100' kv='2'/>");
  ASSERT_EQ(servo.model.muscles.size(), 1U);
  EXPECT_EQ(servo.model.tendons.size(), 0U);
  EXPECT_DOUBLE_EQ(servo.model.muscles[0].shock_cord.damping, 302.0);
  EXPECT_TRUE(hasRemark(servo.remarks, "tendon damping", true, "robot.xml:10"));
  const double placeholder = pulled("", "<motor tendon='t'/>").model.muscles[0].shock_cord.damping;
  EXPECT_DOUBLE_EQ(pulled(" damping='3'", "<motor tendon='t'/>").model.muscles[0].shock_cord.damping,
                   placeholder + 3.0);
  // Beside a spring it has a line of its own.
  const ArmModel sprung = pulled(" damping='300' stiffness='50'", "<position tendon='t' kp='100'/>").model;
  EXPECT_DOUBLE_EQ(sprung.muscles[0].shock_cord.damping, 0.0);
  EXPECT_DOUBLE_EQ(sprung.tendons[0].p[2], 300.0);
}

TEST(MjcfEffects, FrictionOfABallIsAVectorHere) {
  const ImportedArm read = readText(robot("", swinging(" type='ball' frictionloss='0.2'")));
  EXPECT_DOUBLE_EQ(read.model.joints[0].coulomb_friction, 0.2);
  EXPECT_TRUE(hasRemark(read.remarks, "joint frictionloss", true, "robot.xml:4"));
}

TEST(MjcfEffects, AWheelWithoutACoefficientTurnsNothing) {
  const std::string joints = swinging("") + "<joint name='k' axis='0 1 0'/>\n";
  const auto wheels = [&](const std::string& coef) {
    return robot("", joints,
                 "<tendon>\n<fixed name='t' stiffness='5'><joint joint='h' coef='" + coef +
                     "'/><joint joint='k' coef='0'/></fixed></tendon>\n");
  };
  EXPECT_EQ(readText(wheels("0.5")).model.tendons.at(0).between.size(), 1U);
  const ImportedArm still = readText(wheels("0"));
  EXPECT_TRUE(still.model.tendons.empty());
  EXPECT_TRUE(hasRemark(still.remarks, "tendon of one length", false, "robot.xml:10"));
}

}  // namespace
}  // namespace simgap::test
