// MJCF as it is written: what MuJoCo has another word for, or none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mjcf_texts.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

/// A link on a hinge, of an inertia about its axis z [kg m^2].
ArmModel linkOf(double inertia, const std::string& joint = "", const std::string& tail = "") {
  return readText(robot("<compiler angle='radian'/>\n",
                        "<joint name='h'" + joint + "/>\n" +
                            fmt::format("<inertial pos='0 0 0' mass='0.01' diaginertia='{0} {0} {0}'/>\n", inertia),
                        tail))
      .model;
}

std::string doneAbout(const ExportedArm& written, const std::string& what) {
  for (const ExchangeRemark& remark : written.remarks) {
    if (remark.what == what) return remark.done;
  }
  return "nothing was said";
}

TEST(MjcfWriter, FrictionOfAMotorDampsItsJoint) {
  ArmModel arm = linkOf(1e-4, " damping='0.2'", "<actuator><motor name='m' joint='h'/></actuator>\n");
  arm.tendons.at(0).p[3] = 0.5;
  const ExportedArm written = writeMjcf(arm);
  EXPECT_DOUBLE_EQ(readText(written.text).model.joints[0].viscous_friction, 0.7);
  EXPECT_THAT(doneAbout(written, "a motor at a joint"), HasSubstr("its friction is a part of the joint's damping"));
}

TEST(MjcfWriter, KeepsInertiasThatMujocoTakes) {
  const auto back = [](double inertia) {
    return massProperties(readText(writeMjcf(linkOf(inertia)).text).model.bodies[1]).inertia(2, 2);
  };
  EXPECT_DOUBLE_EQ(back(7e-13), 7e-13);
  EXPECT_DOUBLE_EQ(back(3e-15), 2e-14) << "MuJoCo refuses what is below 1e-14";
  EXPECT_THAT(doneAbout(writeMjcf(linkOf(3e-15)), "body 'b' with hardly any inertia"), HasSubstr("2e-14 kg m^2"));
}

TEST(MjcfWriter, SaysHowFarTheLightestStopGivesWay) {
  // (1 - 0.99) (2 ms)^2 0.1 Nm / 1e-6 kg m^2 = 0.004 rad
  EXPECT_THAT(doneAbout(writeMjcf(linkOf(1e-6, " range='-1 1'")), "joint limits"),
              HasSubstr("give way by 4e-08 s^2 of the acceleration that they hold back: 0.1 Nm press 'h', the lightest "
                        "behind a stop, 0.23 deg beyond it"));
  EXPECT_EQ(doneAbout(writeMjcf(linkOf(1e-6)), "joint limits"), "nothing was said");
}

TEST(MjcfWriter, JointsThatStandApartKeepBodiesOfTheirOwn) {
  const auto link = [](const std::string& name, const std::string& mass) {
    return "<link name='" + name + "'>" + mass + "</link>\n";
  };
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child, double down) {
    return fmt::format(
        "<joint name='{}' type='continuous'><parent link='{}'/><child link='{}'/><origin xyz='0 0 {}'/></joint>\n",
        name, parent, child, -down);
  };
  const std::string heavy =
      "<inertial><origin xyz='0 0 -.1'/><mass value='1'/><inertia ixx='.01' iyy='.01' izz='.01'/></inertial>";
  for (const double apart : {0.02, 0.0}) {
    const ArmModel arm = readUrdf("<robot name='r'>" + link("world", "") + link("l2_1", "") + link("l2", heavy) +
                                      joint("j1", "world", "l2_1", 1.0) + joint("j2", "l2_1", "l2", apart) + "</robot>",
                                  "robot.urdf")
                             .model;
    const std::string text = writeMjcf(arm).text;
    const ArmModel back = readText(text).model;
    ASSERT_EQ(back.bodies.size(), 3U);
    const auto placed = [](const ArmModel& model) { return bodiesInWorld(model, std::vector<JointPosition>(2)); };
    for (std::size_t b = 1; b < 3; ++b) {
      EXPECT_EQ(back.bodies[b].name, arm.bodies[b].name);
      EXPECT_NEAR((placed(back)[b].origin - placed(arm)[b].origin).norm(), 0.0, 1e-12);
    }
    EXPECT_EQ(text.find("body name=\"l2_1\"") == std::string::npos, apart == 0.0) << "one body has both where it can";
  }
}

}  // namespace
}  // namespace simgap::test
