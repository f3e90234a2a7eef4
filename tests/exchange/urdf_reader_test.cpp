// URDF by hand: what each element means is worked out here, not by the reader.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "mjcf_texts.h"
#include "simgap/core/error.h"
#include "simgap/exchange/exchange.h"
#include "simgap/model/arm/kinematics.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

constexpr const char* kLink =
    "<inertial><origin xyz='0 0 -0.1'/><mass value='2'/>"
    "<inertia ixx='0.02' iyy='0.03' izz='0.02' ixy='0.001'/></inertial>";

/// Two links with mass on a base, and `joints` between them.
std::string robotOf(const std::string& joints) {
  return "<robot name='r'>\n<link name='base'/>\n<link name='a'>" + std::string(kLink) + "</link>\n<link name='b'>" +
         kLink + "</link>\n" + joints + "</robot>\n";
}
std::string urdfJoint(const std::string& name, const std::string& type, const std::string& parent,
                      const std::string& child, const std::string& more = "") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/>" +
         more + "</joint>\n";
}
ArmModel read(const std::string& joints) { return readUrdf(robotOf(joints), "r.urdf").model; }
std::string urdfRefused(const std::string& text) {
  return errorOf([&] { readUrdf(text, "r.urdf"); });
}

TEST(UrdfReader, ReadsHingesAndSlidesWithTheirLimitsAndFrictions) {
  const ArmModel arm = read(urdfJoint("lift", "prismatic", "base", "a",
                                      "<origin xyz='0.1 0 0.2' rpy='0 0 1.5707963267948966'/><axis xyz='0 2 0'/><limit "
                                      "lower='-0.1' upper='0.3' effort='1' velocity='1'/>") +
                            urdfJoint("turn", "revolute", "a", "b",
                                      "<limit lower='-1' upper='2' effort='1' velocity='1'/><dynamics damping='0.5' "
                                      "friction='0.1'/>"));
  ASSERT_EQ(arm.joints.size(), 2U);
  const Joint &lift = arm.joints[0], &turn = arm.joints[1];
  EXPECT_EQ(lift.type, JointType::kPrismatic);
  EXPECT_EQ(lift.axis, Eigen::Vector3d::UnitY());
  EXPECT_DOUBLE_EQ(lift.upper_limit, 0.3);
  EXPECT_EQ(turn.axis, Eigen::Vector3d::UnitX()) << "without an axis";
  EXPECT_DOUBLE_EQ(turn.lower_limit, -1.0);
  EXPECT_DOUBLE_EQ(turn.viscous_friction, 0.5);
  EXPECT_DOUBLE_EQ(turn.coulomb_friction, 0.1);
  // A way of 0.2 along y of a frame that is turned by 90 deg about z leads along -x.
  std::vector<JointPosition> q(2);
  q[0].angle = 0.2;
  const std::vector<BodyInWorld> bodies = bodiesInWorld(arm, q);
  EXPECT_LT((bodies[lift.child].origin - Eigen::Vector3d(-0.1, 0.0, 0.2)).norm(), 1e-12);
}

TEST(UrdfReader, AFixedLinkIsAPartOfItsParent) {
  const ArmModel arm =
      read(urdfJoint("turn", "continuous", "base", "a") +
           urdfJoint("weld", "fixed", "a", "b", "<origin xyz='0 0 -0.3' rpy='3.141592653589793 0 0'/>"));
  ASSERT_EQ(arm.joints.size(), 1U);
  EXPECT_LT(arm.joints[0].lower_limit, -1e6) << "continuous: no limits";
  const MassProperties mass = massProperties(arm.bodies[arm.joints[0].child]);
  EXPECT_DOUBLE_EQ(mass.mass, 4.0);
  // At -0.1 and, upside down, at -0.3 + 0.1.
  EXPECT_NEAR(mass.centre_of_mass.z(), -0.15, 1e-12);
  EXPECT_NEAR(mass.inertia(0, 0), 2 * 0.02 + 4.0 * 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(mass.inertia(0, 1), 0.001 - 0.001, 1e-12) << "a product changes its sign when turned about x";
}

TEST(UrdfReader, AMimicFollows) {
  const ArmModel arm =
      read(urdfJoint("turn", "continuous", "base", "a") +
           urdfJoint("other", "continuous", "a", "b", "<mimic joint='turn' multiplier='0.5' offset='0.2'/>"));
  ASSERT_TRUE(arm.joints[1].follows());
  EXPECT_EQ(arm.joints[1].leader, 0);
  EXPECT_DOUBLE_EQ(arm.joints[1].coupling_ratio, 0.5);
  EXPECT_DOUBLE_EQ(arm.joints[1].coupling_offset, 0.2);
}

TEST(UrdfReader, WhatIsLeftOutIsSaidWithItsLine) {
  const ImportedArm imported =
      readUrdf(robotOf(urdfJoint("turn", "continuous", "base", "a") +
                       urdfJoint("more", "continuous", "a", "b", "<safety_controller k_velocity='1'/>") +
                       "<transmission name='t'/>\n"),
               "r.urdf");
  const auto has = [&](const std::string& what, const std::string& place) {
    return std::ranges::any_of(imported.remarks, [&](const ExchangeRemark& r) {
      return r.what.find(what) != std::string::npos && std::ranges::find(r.places, place) != r.places.end();
    });
  };
  EXPECT_TRUE(has("safety_controller", "r.urdf:6"));
  EXPECT_TRUE(has("transmission", "r.urdf:7"));
}

TEST(UrdfReader, ABaseThatWeighsSomethingStandsStillAndThatIsSaid) {
  const auto places = [](const std::string& base, const std::string& mass) {
    const ImportedArm imported =
        readUrdf("<robot name='r'>\n<link name='" + base + "'>" + mass + "</link>\n<link name='a'>" + kLink +
                     "</link>\n" + urdfJoint("turn", "continuous", base, "a") + "</robot>",
                 "r.urdf");
    std::vector<std::string> found;
    for (const ExchangeRemark& r : imported.remarks) {
      if (r.what == "a base without a joint to the world" && r.matters) found = r.places;
    }
    return found;
  };
  EXPECT_EQ(places("base", kLink), std::vector<std::string>{"r.urdf:2"});
  EXPECT_TRUE(places("base", "").empty());
  EXPECT_TRUE(places("world", kLink).empty());
}

TEST(UrdfReader, MacrosHaveToBeExpandedFirst) {
  const std::string head = "<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'>\n";
  EXPECT_EQ(urdfRefused(head + "<xacro:include filename='x.xacro'/>\n<xacro:arm/></robot>"),
            "3: r.urdf:2: xacro:include: found 'xacro:include', a macro of xacro: expand it with xacro first");
  EXPECT_THAT(urdfRefused(head + "<link name='${side}_arm'/></robot>"), HasSubstr("found '${side}_arm', a macro"));
  EXPECT_THAT(urdfRefused("<robot name='r'/>"), HasSubstr("found no link, expected at least two"));
}

TEST(UrdfReader, ANameIsUtf8) {
  EXPECT_THAT(urdfRefused("<robot name='r'>\n<link name='\xE9paule'/></robot>"),
              HasSubstr("r.urdf:2: link: found a text that is no UTF-8"));
  const std::string turn = urdfJoint("\xC3\xA9paule", "continuous", "base", "a");
  EXPECT_THAT(urdfRefused(robotOf(turn)), HasSubstr("found 2 links")) << "two bytes that are one letter are read";
}

TEST(UrdfReader, RefusesWhatIsNoTreeOfThoseJoints) {
  const std::string turn = urdfJoint("turn", "continuous", "base", "a");
  EXPECT_THAT(urdfRefused(robotOf(urdfJoint("free", "floating", "base", "a"))), HasSubstr("type: found 'floating'"));
  EXPECT_THAT(urdfRefused(robotOf(turn + urdfJoint("t", "hinge", "a", "b"))),
              HasSubstr("expected revolute, continuous"));
  EXPECT_THAT(urdfRefused(robotOf(turn + urdfJoint("t", "continuous", "a", "c"))),
              HasSubstr("found 'c', expected the name of a link"));
  EXPECT_THAT(urdfRefused(robotOf(turn + urdfJoint("t", "continuous", "base", "a"))), HasSubstr("child of two joints"));
  EXPECT_THAT(urdfRefused(robotOf(turn + urdfJoint("round", "continuous", "b", "b"))),
              HasSubstr("r.urdf:4: link 'b' hangs on itself: its joints run in a circle, expected a tree"));
  EXPECT_THAT(urdfRefused(robotOf(turn)), HasSubstr("found 2 links that hang on no other"));
  EXPECT_THAT(urdfRefused(robotOf(turn + urdfJoint("t", "revolute", "a", "b", "<limit lower='1' upper='0'/>"))),
              HasSubstr("found lower 1 above upper 0"));
  EXPECT_THAT(urdfRefused(robotOf(turn + urdfJoint("t", "revolute", "a", "b", "<axis xyz='0 0 0'/>"))),
              HasSubstr("found a zero vector"));
  EXPECT_THAT(urdfRefused(robotOf(turn + urdfJoint("t", "continuous", "a", "b", "<mimic joint='x'/>"))),
              HasSubstr("mimic: found 'x'"));
  EXPECT_THAT(urdfRefused("<mujoco/>"), HasSubstr("r.urdf"));
}

TEST(UrdfReader, SaysWhichLinkMovesWithoutAMass) {
  const auto said = [](const std::string& shape) {
    return readUrdf("<robot name='r'>\n<link name='base'/>\n<link name='a'>" + shape + "</link>\n<link name='b'>" +
                        kLink + "</link>\n<link name='tool'/>\n" + urdfJoint("i", "continuous", "base", "a") +
                        urdfJoint("j", "continuous", "a", "b") + urdfJoint("k", "fixed", "b", "tool") + "</robot>",
                    "r.urdf")
        .remarks;
  };
  const auto find = [](const std::vector<ExchangeRemark>& remarks, const std::string& what) {
    return std::ranges::find(remarks, what, &ExchangeRemark::what);
  };
  const std::vector<ExchangeRemark> drawn = said("<visual><geometry><box size='1 1 1'/></geometry></visual>");
  const auto found = find(drawn, "link 'a' without inertial");
  ASSERT_NE(found, drawn.end());
  EXPECT_TRUE(found->matters);
  EXPECT_THAT(found->places, testing::ElementsAre("r.urdf:3"));
  EXPECT_EQ(find(drawn, "link 'tool' without inertial"), drawn.end()) << "it is a part of what has a mass";
  const std::vector<ExchangeRemark> bare = said("");
  ASSERT_NE(find(bare, "link 'a' without inertial"), bare.end());
  EXPECT_FALSE(find(bare, "link 'a' without inertial")->matters) << "it only stands between two joints";
}

TEST(UrdfReader, SaysWhichHingeHasNoLimitThoughItsKindAsksForOne) {
  const auto matters = [](const std::string& type, const std::string& limit) {
    const std::string joint = urdfJoint("j", type, "base", "a");
    const std::string end = "</joint>";
    const std::string text =
        "<robot name='r'>\n<link name='base'/>\n<link name='a'><inertial><mass value='1'/><inertia ixx='0.1' iyy='0.1' "
        "izz='0.1'/></inertial></link>\n" +
        joint.substr(0, joint.rfind(end)) + limit + end + "</robot>";
    return hasRemark(readUrdf(text, "r.urdf").remarks, type + " joint without limit", true, "r.urdf:4");
  };
  EXPECT_TRUE(matters("revolute", ""));
  EXPECT_TRUE(matters("prismatic", ""));
  EXPECT_FALSE(matters("revolute", "<limit lower='-1' upper='1'/>"));
  EXPECT_FALSE(matters("continuous", ""));
}

TEST(UrdfReader, SaysAtWhichLinkAnInertiaCannotBe) {
  EXPECT_THAT(urdfRefused("<robot name='r'>\n<link name='base'/>\n<link name='a'><inertial><mass value='1'/><inertia "
                          "ixx='0.1' iyy='0.1' izz='9'/></inertial></link>\n" +
                          urdfJoint("j", "continuous", "base", "a") + "</robot>"),
              HasSubstr("r.urdf:3: body 'a': inertia_kg_m2: found principal moments"));
}

}  // namespace
}  // namespace simgap::test
