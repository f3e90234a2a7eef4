// Servos that push, in MJCF: what MuJoCo's law says is worked out here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "mjcf_texts.h"
#include "simgap/exchange/exchange.h"
#include "simgap/model/arm/tendon_kind.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

/// Two fingers' joints in one body each, and a fixed tendon of both.
std::string twoHinges(const std::string& tendon, const std::string& actuator) {
  return robot("<compiler angle='radian'/>\n",
               std::string("<joint name='a' ref='0.2'/>\n") + kBall +
                   "<body pos='0 0 1'><joint name='c'/><geom size='0.1' mass='1'/></body>\n",
               "<tendon><fixed name='t'" + tendon +
                   "><joint joint='a' coef='0.5'/><joint joint='c' coef='-2'/></fixed>" + "</tendon>\n<actuator>" +
                   actuator + "</actuator>\n");
}

TEST(MjcfDrives, AServoOnAFixedTendonPushesAsWellAsItPulls) {
  // MuJoCo: length 0.5 (qa + 0.2) - 2 qc, force along it 3 (40 u + 5 - 60 (3 L) - 7 (3 dL/dt)).
  const ArmModel arm =
      readText(
          twoHinges("", "<general name='g' tendon='t' gear='3' gainprm='40' biastype='affine' biasprm='5 -60 -7'/>"))
          .model;
  EXPECT_TRUE(arm.muscles.empty());
  ASSERT_EQ(arm.tendons.size(), 1U);
  const PassiveTendon& servo = arm.tendons[0];
  EXPECT_EQ(servo.kind->name, "line-servo");
  ASSERT_TRUE(servo.jointsOnly());
  EXPECT_DOUBLE_EQ(servo.between[0].radius, 0.5);
  EXPECT_DOUBLE_EQ(servo.between[1].radius, -2.0);
  for (const double u : {-0.4, 0.9}) {
    const double ours = 0.5 * 0.3 - 2.0 * 0.1, there = ours + 0.5 * 0.2, rate = 0.2;
    const double force = 3.0 * (40.0 * u + 5.0 - 60.0 * 3.0 * there - 7.0 * 3.0 * rate);
    EXPECT_NEAR(-servo.kind->force(servo.p, ours, rate, 40.0 / 180.0 * u), force, 1e-12) << u;
  }
}

TEST(MjcfDrives, AServoOfALineComesBackAsItWas) {
  const ArmModel arm = readText(twoHinges(" damping='0.3'", "<position tendon='t' kp='6' kv='0.5'/>")).model;
  const ArmModel back = readText(writeMjcf(arm).text).model;
  ASSERT_EQ(back.tendons.size(), 1U);
  EXPECT_EQ(back.tendons[0].kind->name, "line-servo");
  EXPECT_NEAR(back.tendons[0].p[0], 6.0, 1e-12);
  EXPECT_NEAR(back.tendons[0].p[1], -0.1, 1e-12) << "a counts from its reference";
  EXPECT_NEAR(back.tendons[0].p[2], 0.8, 1e-12) << "the tendon's damping beside the servo's";
}

TEST(MjcfDrives, AServoThatOnlyPullsIsAMuscle) {
  const ArmModel arm = readText(twoHinges("", "<position tendon='t' kp='6' forcerange='-50 0'/>")).model;
  EXPECT_EQ(arm.muscles.size(), 1U);
  EXPECT_TRUE(arm.tendons.empty());
}

TEST(MjcfDrives, WhichWayAForceActsIsItsGears) {
  const auto kinds = [](const std::string& actuator) {
    const ArmModel arm = readText(twoHinges("", actuator)).model;
    return std::pair(arm.muscles.size(), arm.tendons.size());
  };
  EXPECT_EQ(kinds("<position tendon='t' kp='6' gear='-1' forcerange='-50 0'/>"), std::pair(0UL, 1UL)) << "pushes";
  EXPECT_EQ(kinds("<position tendon='t' kp='6' gear='-1' forcerange='0 50'/>"), std::pair(1UL, 0UL)) << "pulls";
}

TEST(MjcfDrives, WhatPushesIsSaidOfAMuscleThatItsRateDrives) {
  const ImportedArm read =
      readText(twoHinges("", "<general tendon='t' gear='3' gainprm='40' biastype='affine' biasprm='5 -60 7'/>"));
  ASSERT_EQ(read.model.muscles.size(), 1U) << "a damping below 0 is no servo's";
  EXPECT_TRUE(hasRemark(read.remarks, "general that pushes", true, "robot.xml:11"));
}

TEST(MjcfDrives, WhatExertsNoForceIsNoMuscle) {
  for (const char* none : {"<position tendon='t' kp='0'/>", "<general tendon='t' gear='0' gainprm='7'/>"}) {
    const ImportedArm read = readText(twoHinges("", none));
    EXPECT_TRUE(read.model.muscles.empty()) << none;
    ASSERT_EQ(read.model.tendons.size(), 1U) << none;
    EXPECT_EQ(read.model.tendons[0].kind->name, "constant-force") << none;
  }
}

TEST(MjcfDrives, ATendonThatNoJointChangesIsLeftOutWithItsActuator) {
  const std::string body = std::string("<joint name='h'/>\n<site name='p'/><site name='q' pos='0 0 1'/>\n") + kBall;
  for (const char* constant : {"<fixed name='t'><joint joint='h' coef='0'/></fixed>",
                               "<spatial name='t'><site site='p'/><site site='q'/></spatial>"}) {
    const ImportedArm read = readText(
        robot("", body, std::string("<tendon>") + constant + "</tendon>\n<actuator><motor tendon='t'/></actuator>\n"));
    EXPECT_TRUE(read.model.muscles.empty()) << constant;
    EXPECT_TRUE(read.model.tendons.empty()) << constant;
    EXPECT_TRUE(hasRemark(read.remarks, "tendon of one length", false, "robot.xml:9")) << constant;
    EXPECT_TRUE(hasRemark(read.remarks, "motor (actuator of a tendon)", false, "robot.xml:10")) << constant;
  }
}

TEST(MjcfDrives, AServoMovesASlide) {
  const ArmModel arm = readText(robot("", std::string("<joint name='s' type='slide' ref='0.1'/>\n") + kBall,
                                      "<actuator><position joint='s' kp='900' kv='4'/></actuator>\n"))
                           .model;
  ASSERT_EQ(arm.tendons.size(), 1U);
  const PassiveTendon& servo = arm.tendons[0];
  EXPECT_EQ(servo.kind->name, "line-servo");
  // MuJoCo: 900 (u - (q + 0.1)) - 4 dq/dt towards larger q.
  EXPECT_NEAR(-servo.kind->force(servo.p, 0.03, 0.5, 0.2), 900.0 * (0.2 - 0.13) - 4.0 * 0.5, 1e-12);
}

TEST(MjcfContacts, AreNamedWhereGeomsMayTouch) {
  const std::string floor = "<worldbody><geom type='plane' size='1 1 1'/></worldbody>\n";
  const auto places = [](const ImportedArm& read) {
    for (const ExchangeRemark& remark : read.remarks) {
      if (remark.what == "contacts of a geom with others" && remark.matters) return remark.places;
    }
    return std::vector<std::string>{};
  };
  using testing::ElementsAre;
  using testing::IsEmpty;
  const std::string hinge = std::string("<joint name='h'/>\n") + kBall;
  EXPECT_THAT(places(readText(robot("", hinge, floor))), ElementsAre("robot.xml:5", "robot.xml:8"));
  EXPECT_THAT(places(readText(robot("", hinge))), IsEmpty()) << "nothing to touch";
  EXPECT_THAT(places(readText(robot("<option><flag contact='disable'/></option>\n", hinge, floor))), IsEmpty());
  const std::string through = "<joint name='h'/>\n<geom size='0.1' mass='2' contype='0' conaffinity='0'/>\n";
  EXPECT_THAT(places(readText(robot("", through, floor))), IsEmpty());
  const std::string next = "<body pos='0 0 1'><joint/><geom size='0.1' mass='1'/></body>\n";
  EXPECT_THAT(places(readText(robot("", hinge + next))), IsEmpty()) << "neighbours do not touch in MuJoCo";
  const std::string unfiltered = "<option><flag filterparent='disable'/></option>\n";
  EXPECT_THAT(places(readText(robot(unfiltered, hinge + next))), testing::SizeIs(2));
  const std::string excluded = "<contact><exclude body1='world' body2='b'/></contact>\n";
  EXPECT_THAT(places(readText(robot("", hinge, floor + excluded))), IsEmpty());
  const std::string named = "<joint name='h'/>\n<geom name='g' size='0.1' mass='2' contype='0' conaffinity='0'/>\n";
  const std::string pair =
      "<worldbody><geom name='f' type='plane' size='1 1 1' contype='0' conaffinity='0'/>"
      "</worldbody><contact><pair geom1='g' geom2='f'/></contact>\n";
  EXPECT_THAT(places(readText(robot("", named, pair))), testing::SizeIs(2));
  const std::string fork = "<body><joint/><geom size='0.1'/></body>\n<body><joint/><geom size='0.1'/></body>\n";
  EXPECT_THAT(places(readText(robot("", named + fork, pair))), testing::SizeIs(4)) << "a pair excludes no others";
}

TEST(MjcfContacts, ALooseThingMattersWhereItCanTouch) {
  const auto ball = [](const std::string& more) {
    return "<worldbody><body name='ball'><freejoint/><geom size='0.02' " + more + "/></body></worldbody>\n";
  };
  const std::string hinge = std::string("<joint name='h'/>\n") + kBall;
  EXPECT_TRUE(hasRemark(readText(robot("", hinge, ball(""))).remarks, "body with a free joint", true, "robot.xml:8"));
  EXPECT_TRUE(hasRemark(readText(robot("", hinge, ball("contype='0' conaffinity='0'"))).remarks,
                        "body with a free joint", false, "robot.xml:8"));
}

TEST(MjcfContacts, AModelWithoutConstraintsIsNamed) {
  const ImportedArm read =
      readText(robot("<option><flag constraint='disable'/></option>\n", std::string("<joint name='h'/>\n") + kBall));
  EXPECT_TRUE(hasRemark(read.remarks, "flag constraint", true, "robot.xml:2"));
}

TEST(MjcfMasses, MomentsOfNoBodyAreBalancedWhereTheCompilerSaysSo) {
  const std::string body = "<joint name='h'/>\n<inertial pos='0.1 0 0' mass='2' diaginertia='0.01 0.01 0.04'/>\n";
  const ArmModel arm = readText(robot("<compiler balanceinertia='true'/>\n", body)).model;
  const Eigen::Matrix3d inertia = massProperties(arm.bodies[1]).inertia;
  EXPECT_LT((inertia - 0.02 * Eigen::Matrix3d::Identity()).norm(), 1e-15);
  EXPECT_THAT(refusal(robot("", body)), HasSubstr("inertia"));
}

}  // namespace
}  // namespace simgap::test
