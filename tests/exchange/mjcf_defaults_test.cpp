// How MuJoCo reads defaults, ranges and orientations. Numbers said to be MuJoCo's were printed by MuJoCo 3.3 for the
// same text; the others are worked out here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "mjcf_texts.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

std::string hinge(const std::string& attributes = "") { return "<joint name='h' " + attributes + "/>\n" + kBall; }

/// Torque [N m] of the drive at control 1, angle 0.1, velocity 0.2.
double driveTorque(const PassiveTendon& drive) { return -drive.kind->force(drive.p, 0.1, 0.2, 1.0); }

TEST(MjcfDefaults, ATendonsAreThoseOfSpatialAndFixed) {
  const ArmModel arm = readText(robot("<default><tendon stiffness='300' springlength='0.08' damping='2'/></default>\n",
                                      hinge() + "<site name='in' pos='0.1 0 0'/>\n",
                                      "<worldbody><site name='out'/></worldbody>"
                                      "<tendon><spatial name='s'><site site='in'/><site site='out'/></spatial>"
                                      "<fixed name='f' damping='3'><joint joint='h' coef='0.1'/></fixed></tendon>"))
                           .model;
  ASSERT_EQ(arm.tendons.size(), 2U);
  for (const PassiveTendon& line : arm.tendons) {
    EXPECT_EQ(line.kind->name, "spring");
    EXPECT_DOUBLE_EQ(line.p[0], 0.08);
    EXPECT_DOUBLE_EQ(line.p[1], 300.0);
    EXPECT_DOUBLE_EQ(line.p[2], line.name == "f" ? 3.0 : 2.0);
  }
}

TEST(MjcfDefaults, AnEqualitysAreThoseOfItsKinds) {
  const std::string tied = hinge() + "<joint name='k' axis='0 1 0'/>\n";
  const auto read = [&](const std::string& more) {
    return readText(robot("<default><equality active='false'/></default>\n", tied,
                          "<equality><joint joint1='k' joint2='h' " + more + "/></equality>"))
        .model;
  };
  EXPECT_FALSE(read("").joints[1].follows());
  EXPECT_TRUE(read("active='true'").joints[1].follows());
}

TEST(MjcfDefaults, ActuatorsOfAllKindsShareOne) {
  const auto read = [](const std::string& defaults, const std::string& actuators) {
    return readText(robot("<default>" + defaults + "</default>\n", hinge() + "<joint name='k' axis='0 1 0'/>\n",
                          "<actuator>" + actuators + "</actuator>"));
  };
  // MuJoCo: gear 3 of both, kp 50, force within 7 N m.
  const ImportedArm general =
      read("<general gear='3' forcerange='-7 7'/>", "<position joint='h' kp='50'/>\n<motor joint='k'/>");
  ASSERT_EQ(general.model.tendons.size(), 2U);
  EXPECT_DOUBLE_EQ(driveTorque(general.model.tendons[0]), 3.0 * (50.0 * (3.0 * (1.0 - 0.1))))
      << "3 (50 u - 50 * 3 q), where our target is a third of u";
  EXPECT_DOUBLE_EQ(driveTorque(general.model.tendons[1]), 3.0);
  EXPECT_TRUE(hasRemark(general.remarks, "actuator forcerange", true, "robot.xml:10"));
  // MuJoCo: what <motor> says last holds for a servo, too; gain 50, bias 0 -50 0.
  const ArmModel motor =
      read("<position gear='4'/><motor gear='20' ctrlrange='-1 1'/>", "<position joint='h' kp='50'/>").model;
  EXPECT_DOUBLE_EQ(driveTorque(motor.tendons[0]), 20.0 * 50.0 * 20.0 * 0.9);
  // MuJoCo: gain 80, bias 0 -80 0 of the general, gear 2; the motor is one all the same.
  const ArmModel position = read("<position kp='80' gear='2'/>", "<general joint='h'/><motor joint='k'/>").model;
  EXPECT_DOUBLE_EQ(driveTorque(position.tendons[0]), 2.0 * 80.0 * 2.0 * 0.9);
  EXPECT_EQ(position.tendons[1].kind->name, "joint-motor");
  EXPECT_DOUBLE_EQ(driveTorque(position.tendons[1]), 2.0);
}

TEST(MjcfDefaults, AListSaysItsFirstNumbersOver) {
  // MuJoCo: bias 0 -50 -8, and a capsule of 0.39584 kg (radius 0.03, half length 0.05 of the class).
  const ArmModel arm =
      readText(robot("<default><default class='k'><general biastype='affine' gainprm='50' biasprm='0 -40 -8'/>"
                     "<geom type='capsule' size='.02 .05'/></default></default>\n",
                     "<joint name='h'/>\n<geom class='k' size='.03'/>\n",
                     "<actuator><general class='k' joint='h' biasprm='0 -50'/></actuator>"))
          .model;
  EXPECT_NEAR(massProperties(arm.bodies[1]).mass, 0.39584067435231396, 1e-12);
  EXPECT_DOUBLE_EQ(driveTorque(arm.tendons[0]), 50.0 * 0.9 - 8.0 * 0.2);
}

TEST(MjcfDefaults, WhatAnElementSaysOverIsNoRemark) {
  const ImportedArm read = readText(robot("<default><joint damping='1' magic='1'/></default>\n", hinge("damping='2'")));
  EXPECT_TRUE(hasRemark(read.remarks, "joint magic", true, "robot.xml:2"));
  for (const ExchangeRemark& remark : read.remarks) EXPECT_NE(remark.what, "joint damping");
}

TEST(MjcfDefaults, TheOutermostClassHoldsForAllWhateverItIsCalled) {
  const ArmModel arm = readText(robot("<default class='robot'><joint damping='3'/></default>\n", hinge())).model;
  EXPECT_DOUBLE_EQ(arm.joints[0].viscous_friction, 3.0);
}

TEST(MjcfDefaults, ARangeLimitsWhereItsFirstNumberIsTheSmaller) {
  // MuJoCo: none of these joints is limited.
  for (const std::string range : {"0 0", "1 1", "2 1"}) {
    const ImportedArm read = readText(robot("", hinge("range='" + range + "'")));
    EXPECT_LT(read.model.joints[0].lower_limit, -1e6) << range;
    EXPECT_GT(read.model.joints[0].upper_limit, 1e6) << range;
    EXPECT_TRUE(hasRemark(read.remarks, "joint range", range == "2 1", "robot.xml:4")) << range;
  }
  const ImportedArm lines =
      readText(robot("", hinge(),
                     "<tendon><fixed name='f' range='0 0' stiffness='1'><joint joint='h' coef='1'/></fixed></tendon>\n"
                     "<actuator><motor joint='h' forcerange='0 0'/></actuator>"));
  EXPECT_TRUE(hasRemark(lines.remarks, "fixed range", false, "robot.xml:8"));
  EXPECT_TRUE(hasRemark(lines.remarks, "motor forcerange", false, "robot.xml:9"));
  for (const ExchangeRemark& remark : lines.remarks) {
    EXPECT_NE(remark.what, "tendon range");
    EXPECT_NE(remark.what, "actuator forcerange");
  }
  const ImportedArm silent = readText(robot("<compiler autolimits='false'/>\n", hinge("range='-1 1'")));
  EXPECT_GT(silent.model.joints[0].upper_limit, 1e6);
  EXPECT_TRUE(hasRemark(silent.remarks, "joint range", true, "robot.xml:5"));
}

TEST(MjcfDefaults, AnEqualityHoldsAJointAndOneThatIsHeldIsWrittenSo) {
  const ArmModel arm =
      readText(robot("", hinge(), "<equality><joint joint1='h' polycoef='0.3 0 0 0 0'/></equality>")).model;
  EXPECT_DOUBLE_EQ(arm.joints[0].lower_limit, 0.3);
  const ArmModel back = readText(writeMjcf(arm).text).model;
  EXPECT_DOUBLE_EQ(back.joints[0].lower_limit, 0.3) << "range='0.3 0.3' would limit nothing";
  EXPECT_DOUBLE_EQ(back.joints[0].upper_limit, 0.3);
}

/// Where z of a geom points that is drawn with these attributes.
Eigen::Vector3d zOf(const std::string& attributes, const std::string& defaults) {
  const ArmModel arm =
      readText(
          robot("<compiler angle='radian'/><default>" + defaults + "</default>",
                hinge() + "<geom name='g' type='cylinder' size='.01 .01' mass='0' " + attributes +
                    "/><site name='a' pos='1 1 0'/>",
                "<worldbody><site name='b' pos='1 1 1'/></worldbody><tendon><spatial stiffness='1'><site site='a'/>"
                "<geom geom='g'/><site site='b'/></spatial></tendon>"))
          .model;
  return arm.bodies[1].surfaces.at(0).axis;
}

TEST(MjcfDefaults, AnyOrientationGoesBeforeAQuat) {
  // MuJoCo: the class's quarter turn about x (z along -y) gives way to an own euler, and stands against nothing else.
  const std::string quat = "<geom quat='1 1 0 0'/>";
  EXPECT_LT((zOf("", quat) + Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((zOf("euler='0 0 .5'", quat) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  // A class's euler about y (z along x) goes before an own quat; the later of two others holds.
  const std::string euler = "<geom euler='0 1.5707963267948966 0'/>";
  EXPECT_LT((zOf("quat='1 1 0 0'", euler) - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((zOf("axisangle='0 0 1 .5'", euler) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_THAT(refusal(robot("", hinge() + "<geom size='.1' quat='1 0 0 0' euler='0 0 1'/>")),
              HasSubstr("found quat and euler, expected one orientation"));
}

TEST(MjcfReader, MinusZIsAHalfTurnAboutX) {
  const ArmModel arm =
      readText("<mujoco><worldbody><body zaxis='0 0 -1'><joint/>" + std::string(kBall) + "</body></worldbody></mujoco>")
          .model;
  const Eigen::Matrix3d turned = bodiesInWorld(arm, std::vector<JointPosition>(1))[1].rotation;
  EXPECT_LT((turned * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitX()).norm(), 1e-12) << "MuJoCo: (1 0 0)";
  EXPECT_LT((turned * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(MjcfReader, BoundinertiaBoundsThePrincipalMoments) {
  // Turned by 45 degrees about y, 1e-4 becomes 0.01: (0.01 + 0.03) / 2 on both axes, (0.03 - 0.01) / 2 beside it.
  const ArmModel arm =
      readText(robot("<compiler boundinertia='0.01'/>\n",
                     "<joint/>\n<inertial pos='0 0 0' mass='1' euler='0 45 0' diaginertia='1e-4 .03 .03'/>\n"))
          .model;
  const Eigen::Matrix3d inertia = massProperties(arm.bodies[1]).inertia;
  EXPECT_NEAR(inertia(0, 0), 0.02, 1e-12);
  EXPECT_NEAR(inertia(1, 1), 0.03, 1e-12);
  EXPECT_NEAR(inertia(2, 2), 0.02, 1e-12);
  EXPECT_NEAR(std::abs(inertia(0, 2)), 0.01, 1e-12);
}

TEST(MjcfReader, ANameIsGivenOnce) {
  const auto taken = [](const std::string& text, const std::string& where) {
    EXPECT_THAT(refusal(text), HasSubstr(where));
  };
  const std::string site = "<site name='s'/>\n";
  taken(robot("", hinge() + "<joint name='h' axis='0 1 0'/>\n"), "robot.xml:6: joint: the name 'h' is taken");
  taken(robot("", hinge() + "<body name='b'/>\n"), "robot.xml:6: body: the name 'b' is taken");
  taken(robot("", hinge() + site + site), "robot.xml:7: site: the name 's' is taken by another site");
  taken(robot("", hinge() + "<geom name='g' size='1'/>\n<geom name='g' size='1'/>\n"), "the name 'g' is taken");
  const std::string line = "<fixed name='t'><joint joint='h' coef='1'/></fixed>\n";
  taken(robot("", hinge(), "<tendon>\n" + line + line + "</tendon>"), "robot.xml:10: fixed: the name 't' is taken");
  const std::string motor = "<motor name='m' joint='h'/>\n";
  taken(robot("", hinge(), "<actuator>\n" + motor + motor + "</actuator>"), "motor: the name 'm' is taken");
  const std::string twice = "<default class='k'/>\n";
  taken(robot("<default>\n" + twice + twice + "</default>\n", hinge()),
        "robot.xml:4: default: the name 'k' is taken by another default class");
}

TEST(MjcfReader, NamesThatOurFilesCannotHoldAreFoundByThoseOfTheFile) {
  const ArmModel arm = readText(robot("", "<joint name='j.1'/>\n<joint name='k' axis='0 1 0'/>\n" + std::string(kBall),
                                      "<tendon><fixed name='t.1'><joint joint='j.1' coef='.02'/></fixed></tendon>\n"
                                      "<equality><joint joint1='k' joint2='j.1'/></equality>\n"
                                      "<actuator><motor name='m.1' joint='j.1'/><position tendon='t.1' kp='100'/>"
                                      "</actuator>"))
                           .model;
  EXPECT_EQ(arm.joints[0].name, "j_1");
  EXPECT_EQ(arm.joints[1].leader, 0);
  ASSERT_EQ(arm.tendons.size(), 2U);
  EXPECT_EQ(arm.tendons[0].name, "t_1");
  EXPECT_EQ(arm.tendons[1].name, "m_1");
}

}  // namespace
}  // namespace simgap::test
