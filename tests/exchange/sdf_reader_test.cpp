// SDF by hand: what each element means is worked out here, not by the reader.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simgap/core/error.h"
#include "simgap/exchange/exchange.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

constexpr const char* kMass =
    "<inertial><pose>0 0 -0.1 0 0 0</pose><mass>2</mass><inertia><ixx>0.02</ixx><iyy>0.03</iyy><izz>0.02</izz>"
    "<ixy>0.001</ixy></inertia></inertial>";

std::string link(const std::string& name, const std::string& pose = "") {
  return "<link name='" + name + "'>" + (pose.empty() ? "" : "<pose>" + pose + "</pose>") + kMass + "</link>\n";
}
std::string sdfJoint(const std::string& name, const std::string& type, const std::string& parent,
                     const std::string& child, const std::string& more = "<axis><xyz>1 0 0</xyz></axis>") {
  return "<joint name='" + name + "' type='" + type + "'><parent>" + parent + "</parent><child>" + child + "</child>" +
         more + "</joint>\n";
}
std::string modelOf(const std::string& inner, const std::string& version = "1.9") {
  return "<sdf version='" + version + "'>\n<model name='r'>\n" + inner + "</model></sdf>\n";
}
ImportedArm readAll(const std::string& inner) { return readSdf(modelOf(inner), "r.sdf"); }
std::string sdfRefused(const std::string& inner) {
  return errorOf([&] { readAll(inner); });
}

TEST(SdfReader, LinksStandInTheModelAndJointsInTheirChildren) {
  // A link 0.5 m up, and on it one that is turned by 90 deg about z; its joint stands 0.1 m beside it.
  const ArmModel arm =
      readAll(
          "<pose>0 0 1 0 0 0</pose>" + link("a", "0 0 0.5 0 0 0") + link("b", "0.2 0 0.5 0 0 1.5707963267948966") +
          sdfJoint("base", "fixed", "world", "a", "") +
          sdfJoint("turn", "revolute", "a", "b",
                   "<pose>0.1 0 0 0 0 0</pose><axis><xyz>0 0 2</xyz><limit><lower>-1</lower><upper>1e16</upper></limit>"
                   "<dynamics><damping>0.5</damping><friction>0.1</friction><spring_stiffness>3</spring_stiffness>"
                   "<spring_reference>0.2</spring_reference></dynamics></axis>"))
          .model;
  ASSERT_EQ(arm.joints.size(), 1U);
  const Joint& turn = arm.joints[0];
  EXPECT_DOUBLE_EQ(turn.lower_limit, -1.0);
  EXPECT_GT(turn.upper_limit, 1e6) << "1e16 is no limit";
  EXPECT_DOUBLE_EQ(turn.viscous_friction, 0.5);
  EXPECT_DOUBLE_EQ(turn.coulomb_friction, 0.1);
  EXPECT_DOUBLE_EQ(turn.spring_stiffness, 3.0);
  EXPECT_DOUBLE_EQ(turn.spring_rest, 0.2);
  std::vector<JointPosition> q(1);
  EXPECT_LT((bodiesInWorld(arm, q)[1].origin - Eigen::Vector3d(0.2, 0.0, 1.5)).norm(), 1e-12) << "as it is drawn";
  // The pivot is 0.1 along x of b, which is y of the world; half a turn carries b's origin to the other side of it.
  q[0].angle = std::numbers::pi;
  EXPECT_LT((bodiesInWorld(arm, q)[1].origin - Eigen::Vector3d(0.2, 0.2, 1.5)).norm(), 1e-12);
  EXPECT_NEAR(massProperties(arm.bodies[1]).inertia(0, 1), 0.001, 1e-15);
}

TEST(SdfReader, FramesStandInOneAnother) {
  const ArmModel arm =
      readAll(
          "<frame name='high'><pose>0 0 2 0 0 0</pose></frame>\n"
          "<frame name='turned' attached_to='high'><pose degrees='true'>0 0 0 90 0 0</pose></frame>\n" +
          link("a") + "<link name='b'><pose relative_to='turned'>0 0 1 0 0 0</pose>" + kMass + "</link>\n" +
          sdfJoint("turn", "continuous", "a", "b", "<axis><xyz expressed_in='a'>0 1 0</xyz></axis>"))
          .model;
  const std::vector<JointPosition> q(1);
  // z of a frame that is turned by 90 deg about x is -y.
  EXPECT_LT((bodiesInWorld(arm, q)[1].origin - Eigen::Vector3d(0.0, -1.0, 2.0)).norm(), 1e-12);
  const Eigen::Vector3d in_world = arm.joints[0].parent_orientation * arm.joints[0].axis;
  EXPECT_LT((in_world - Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

TEST(SdfReader, FramesOfPosesWereCalledFrameBefore) {
  // sdformat turns `frame` of version 1.6 into `relative_to` of 1.7 and ignores it from there on; an empty one is the
  // usual frame, without a word.
  const auto read = [](const std::string& said, const std::string& version) {
    const std::string pose = "<pose " + said + "='a'>0.2 0 0 0 0 0</pose>";
    return readSdf(modelOf(link("a", "0 0 0.5 0 0 0") + "<link name='b'>" + pose + kMass + "</link>\n" +
                               sdfJoint("base", "fixed", "world", "a", "<pose " + said + "=''>0 0 0 0 0 0</pose>") +
                               sdfJoint("turn", "revolute", "a", "b"),
                           version),
                   "r.sdf");
  };
  const auto matters = [](const ExchangeRemark& remark) { return remark.matters; };
  const auto place = [](const ImportedArm& arm) {
    return bodiesInWorld(arm.model, std::vector<JointPosition>(1))[1].origin;
  };
  for (const auto& [said, version] : {std::pair("frame", "1.6"), {"relative_to", "1.6"}, {"relative_to", "1.9"}}) {
    const ImportedArm arm = read(said, version);
    EXPECT_LT((place(arm) - Eigen::Vector3d(0.2, 0.0, 0.5)).norm(), 1e-12) << said << version;
    EXPECT_FALSE(std::ranges::any_of(arm.remarks, matters)) << said << version;
  }
  const ImportedArm ignored = read("frame", "1.7");
  EXPECT_LT((place(ignored) - Eigen::Vector3d(0.2, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_TRUE(std::ranges::any_of(ignored.remarks, matters)) << "named";
}

std::string musclesPlugin(const std::string& inner) {
  return "<plugin filename='libmusc_plugin.so' name='musc_plugin'>\n" + inner + "</plugin>\n";
}
std::string myoMuscle(const std::string& name, const std::string& links) {
  return "<myoMuscle name='" + name + "'>" + links + "</myoMuscle>\n";
}
std::string viaPoint(const std::string& on, const std::string& at, const std::string& type = "FIXPOINT") {
  return "<link name='" + on + "'><viaPoint type='" + type + "'>" + at + "</viaPoint></link>\n";
}
std::string armWith(const std::string& plugin) {
  return link("a", "0 0 0.5 0 0 0") + link("b", "0.2 0 0.5 0 0 1.5707963267948966") +
         sdfJoint("base", "fixed", "world", "a", "") + sdfJoint("turn", "revolute", "a", "b") + plugin;
}

TEST(SdfMuscles, OfCardsflowRunThroughPointsOfTheirLinks) {
  const ImportedArm read = readAll(armWith(
      musclesPlugin(myoMuscle("m.1", viaPoint("a", "0 0 0.1") + viaPoint("b", "0.3 0 0") + viaPoint("b", "0.4 0 0")))));
  ASSERT_EQ(read.model.muscles.size(), 1U);
  const Muscle& muscle = read.model.muscles[0];
  EXPECT_EQ(muscle.name, "m_1") << "a name that our files can hold";
  ASSERT_EQ(muscle.between.size(), 1U);
  // b's x is y of the world: (0, 0, 0.6) to (0.2, 0.3, 0.5), and 0.1 m on.
  const std::vector<JointPosition> drawn(1);
  EXPECT_NEAR(tendonLength(read.model, muscle, bodiesInWorld(read.model, drawn), drawn), std::sqrt(0.14) + 0.1, 1e-12);
  EXPECT_TRUE(
      std::ranges::any_of(read.remarks, [](const ExchangeRemark& r) { return r.what == "myoMuscle" && r.matters; }));
  EXPECT_FALSE(std::ranges::any_of(read.remarks, [](const ExchangeRemark& r) { return r.what == "plugin"; }));
}

TEST(SdfMuscles, PointsOfOtherKindsAreNamedAndMistakesRefused) {
  const ImportedArm read = readAll(armWith(musclesPlugin(myoMuscle(
      "m", viaPoint("a", "0 0 0.1") + viaPoint("a", "0 0 0.2", "SPHERICAL_WRAPPING") + viaPoint("b", "0.3 0 0")))));
  EXPECT_TRUE(read.model.muscles.at(0).between.empty());
  EXPECT_TRUE(std::ranges::any_of(read.remarks, [](const ExchangeRemark& r) {
    return r.what == "viaPoint of type SPHERICAL_WRAPPING" && r.matters && r.places.size() == 1;
  }));
  const auto refused = [](const std::string& links) {
    return sdfRefused(armWith(musclesPlugin(myoMuscle("m", links))));
  };
  EXPECT_THAT(refused(viaPoint("a", "0 0 0.1")), HasSubstr("found 1 points of a line, expected two"));
  EXPECT_THAT(refused(viaPoint("a", "0 0 0.1") + viaPoint("c", "0 0 0")), HasSubstr("found 'c', expected the name of"));
  EXPECT_THAT(refused(viaPoint("a", "0 0") + viaPoint("b", "0 0 0")), HasSubstr("viaPoint"));
}

TEST(SdfReader, AxesOfOldFilesStandInTheModel) {
  // A link that is turned by 90 deg about z: its x is y of the model. sdformat's 1_4.convert says so of files
  // before 1.5.
  const auto axis = [](const std::string& version, const std::string& more) {
    const ArmModel arm =
        readSdf("<sdf version='" + version + "'><model name='r'>" + link("a") +
                    link("b", "0 0 1 0 0 1.5707963267948966") +
                    sdfJoint("j", "revolute", "a", "b", "<axis><xyz>1 0 0</xyz>" + more + "</axis>") + "</model></sdf>",
                "r.sdf")
            .model;
    return Eigen::Vector3d(arm.joints[0].parent_orientation * arm.joints[0].axis);
  };
  const std::string own = "<use_parent_model_frame>0</use_parent_model_frame>";
  EXPECT_LT((axis("1.3", "") - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((axis("1.4", "") - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((axis("1.4", own) - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((axis("1.5", "") - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((axis("1.10", "") - Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

TEST(SdfReader, MimicsBallsAndSlides) {
  const ArmModel arm =
      readAll(link("a") + link("b") + link("c") + link("d") + sdfJoint("slide", "prismatic", "a", "b") +
              sdfJoint("ball", "ball", "b", "c", "") +
              sdfJoint("other", "prismatic", "c", "d",
                       "<axis><xyz>0 1 0</xyz><mimic joint='slide'><multiplier>0.5</multiplier><offset>0.2</offset>"
                       "<reference>0.1</reference></mimic></axis>"))
          .model;
  ASSERT_EQ(arm.joints.size(), 3U);
  EXPECT_EQ(arm.joints[0].type, JointType::kPrismatic);
  EXPECT_EQ(arm.joints[1].type, JointType::kSpherical);
  EXPECT_EQ(arm.joints[2].leader, 0);
  EXPECT_NEAR(arm.joints[2].coupling_offset, 0.2 - 0.5 * 0.1, 1e-15);
}

TEST(SdfReader, NamesWhatItLeavesOutWithItsLine) {
  const ImportedArm read = readAll(link("a") + "<link name='b'><visual name='v'/><magic/>" + kMass + "</link>\n" +
                                   sdfJoint("turn", "revolute", "a", "b"));
  const auto has = [&](const std::string& what, bool matters, const std::string& place) {
    return std::ranges::any_of(read.remarks, [&](const ExchangeRemark& r) {
      return r.what == what && r.matters == matters && std::ranges::find(r.places, place) != r.places.end();
    });
  };
  EXPECT_TRUE(has("visual", false, "r.sdf:4"));
  EXPECT_TRUE(has("magic", true, "r.sdf:4"));
  EXPECT_TRUE(has("a base without a joint to the world", true, "r.sdf:3"));
}

TEST(SdfReader, RefusesWithOneSentence) {
  const std::string two = link("a") + link("b");
  EXPECT_THAT(sdfRefused(two + sdfJoint("j", "screw", "a", "b")),
              HasSubstr("r.sdf:5: joint: type: found 'screw', expected"));
  EXPECT_THAT(sdfRefused(two + sdfJoint("j", "revolute", "a", "x")),
              HasSubstr("found 'x', expected the name of a link"));
  EXPECT_THAT(sdfRefused(two + sdfJoint("j", "revolute", "a", "b", "<axis><xyz>0 0 0</xyz></axis>")),
              HasSubstr("found a zero vector, expected an axis"));
  EXPECT_THAT(sdfRefused(two + sdfJoint("j", "revolute", "a", "b",
                                        "<axis><limit><lower>2</lower><upper>1</upper></limit></axis>")),
              HasSubstr("found lower 2 above upper 1"));
  EXPECT_THAT(sdfRefused(link("a", "0 0 0") + link("b") + sdfJoint("j", "revolute", "a", "b")),
              HasSubstr("found 3 numbers, expected 6"));
  EXPECT_THAT(sdfRefused(link("a", "0 0 nan 0 0 0") + link("b") + sdfJoint("j", "revolute", "a", "b")),
              HasSubstr("found 'nan', expected a finite number"));
  EXPECT_THAT(sdfRefused(two + sdfJoint("j", "revolute", "a", "b") + sdfJoint("k", "revolute", "b", "a")),
              HasSubstr("the joints run in a circle"));
  EXPECT_THAT(
      sdfRefused("<link name='a'><pose relative_to='f'>0 0 0 0 0 0</pose></link><frame name='f' attached_to='a'/>" +
                 link("b") + sdfJoint("j", "revolute", "a", "b")),
      HasSubstr("stands in itself"));
  EXPECT_THAT(sdfRefused(two), HasSubstr("found no model with joints, expected one"));
  EXPECT_THAT(sdfRefused("<static>true</static>" + two + sdfJoint("j", "revolute", "a", "b")),
              HasSubstr("found a model that is static"));
}

TEST(SdfReader, SaysWhatGazeboTakesForALinkWithoutInertial) {
  const std::vector<ExchangeRemark> remarks =
      readAll(link("base") + link("a") + "<link name='tool'/>\n" + sdfJoint("j", "revolute", "base", "a") +
              sdfJoint("k", "fixed", "a", "tool", ""))
          .remarks;
  const auto found = std::ranges::find(remarks, "link 'tool' without inertial", &ExchangeRemark::what);
  ASSERT_NE(found, remarks.end());
  EXPECT_TRUE(found->matters);
  EXPECT_THAT(found->done, HasSubstr("Gazebo takes 1 kg"));
}

TEST(SdfReader, RefusesWordsThatTheFormatDoesNotKnow) {
  const auto posed = [](const std::string& how) {
    return sdfRefused(link("base") + "<link name='a'><pose " + how + ">0 0 0 0 0 0</pose>" + kMass + "</link>\n" +
                      sdfJoint("j", "revolute", "base", "a"));
  };
  EXPECT_THAT(posed("degrees='yes'"), HasSubstr("found 'yes', expected true or false"));
  EXPECT_THAT(posed("rotation_format='quat'"), HasSubstr("found 'quat', expected euler_rpy or quat_xyzw"));
}

}  // namespace
}  // namespace simgap::test
