// simgap/arm/2: what it reads back, what is welded, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"
#include "support/arms.h"
#include "support/files.h"
#include "support/many_kinds.h"

namespace simgap {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

ArmModel readSecond(const std::string& text) { return readArm(YamlNode::parse(text, "a.yaml")); }

TEST(SecondArmFormat, ReadsBackWhatItWrites) {
  const ArmModel model = readSecond(test::kManyKinds);
  const std::string text = writeArm(model);
  EXPECT_THAT(text, StartsWith("format: simgap/arm/2\n"));
  const ArmModel again = readSecond(text);
  EXPECT_EQ(again.bodies, model.bodies);
  EXPECT_EQ(again.joints, model.joints);
  EXPECT_EQ(writeArm(again), text);
  const std::vector<JointPosition> start = startPosition(model);
  const std::vector<BodyInWorld> bodies = bodiesInWorld(model, start);
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    EXPECT_EQ(tendonLength(again, again.muscles[m], bodiesInWorld(again, start), start),
              tendonLength(model, model.muscles[m], bodies, start));
  }
}

TEST(SecondArmFormat, AnArmThatNeedsNothingOfItIsWrittenAsTheFirst) {
  const ArmModel model = test::exampleArm();
  EXPECT_THAT(writeArm(model), StartsWith("format: simgap/arm/1\n"));
  const std::string second = test::replaced(writeArm(model), "simgap/arm/1", "simgap/arm/2");
  EXPECT_EQ(writeArm(readSecond(second)), writeArm(model));
}

TEST(SecondArmFormat, ARobotWithoutMusclesNeedNotSayThatItHasNone) {
  ArmModel model = test::exampleArm();
  model.muscles.clear();
  const std::string first = writeArm(model), none = test::replaced(first, "muscles: []\n", "");
  ASSERT_NE(none, first);
  EXPECT_EQ(writeArm(readSecond(test::replaced(none, "simgap/arm/1", "simgap/arm/2"))), first);
  EXPECT_THAT(test::errorOf([&] { readSecond(none); }), HasSubstr("expected the key 'muscles'"));
}

TEST(SecondArmFormat, FixedJointsAreWelded) {
  const ArmModel model = readSecond(test::kManyKinds);
  ASSERT_EQ(model.bodies.size(), 5u);
  ASSERT_EQ(model.joints.size(), 4u);
  const Body& tip = model.bodies[4];
  ASSERT_EQ(tip.parts.size(), 2u);
  EXPECT_EQ(tip.parts[1].name, "drop");
  EXPECT_LT((tip.parts[1].position - Eigen::Vector3d(0.0, 0.002, -0.05)).norm(), 1e-15);
  // The spring's last point: 0.01 up in the nail's frame, which is turned by 0.5 rad about x.
  const Attachment& end = model.tendons[1].attachments[1];
  EXPECT_EQ(end.body, 4);
  EXPECT_LT((end.point - Eigen::Vector3d(0.0, 0.002 - 0.01 * std::sin(0.5), -0.05 + 0.01 * std::cos(0.5))).norm(),
            1e-15);
}

TEST(SecondArmFormat, CapsulesAndEllipsoidsWeighWhatTheBooksSay) {
  Body body;
  Part part;
  part.shape = Part::Shape::kCapsule, part.mass = 2.0, part.radius = 0.03, part.length = 1e-12;
  body.parts = {part};
  EXPECT_LT((massProperties(body).inertia - 0.4 * 2.0 * 9e-4 * Eigen::Matrix3d::Identity()).norm(), 1e-12);  // a ball
  part.length = 1e4, part.mass = 1e4;  // a thin rod
  body.parts = {part};
  EXPECT_NEAR(massProperties(body).inertia(0, 0), 1e4 * 1e8 / 12.0, 1e-4 * 1e12 / 12.0);
  part.shape = Part::Shape::kEllipsoid, part.size = {0.1, 0.2, 0.3}, part.mass = 1.0;
  part.orientation = Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitZ());  // x along y
  body.parts = {part};
  const Eigen::Vector3d moments = 0.2 * Eigen::Vector3d(0.01 + 0.09, 0.04 + 0.09, 0.01 + 0.04);
  EXPECT_LT((massProperties(body).inertia.diagonal() - moments).norm(), 1e-12);
}

TEST(SecondArmFormat, LimitsOfFollowersAreLimitsOfTheirLeaders) {
  const std::string limited =
      test::replaced(test::kManyKinds, "axis: [1, 0, 0], follows", "axis: [1, 0, 0], upper_limit_rad: 0.7, follows");
  EXPECT_NEAR(readSecond(limited).joints[2].upper_limit, 1.0, 1e-12);
  // A follower that may not turn holds its leader from both sides.
  const std::string fixed = test::replaced(test::kManyKinds, "axis: [1, 0, 0], follows",
                                           "axis: [1, 0, 0], lower_limit_rad: 0.2, upper_limit_rad: 0.2, follows");
  const Joint leader = readSecond(fixed).joints[2];
  EXPECT_NEAR(leader.lower_limit, leader.upper_limit, 1e-12);
}

// q_slide = 0.01 + 0.5 q_follower, q_follower = 0.1 + 0.6 q_hinge; both stand before whom they follow.
TEST(SecondArmFormat, AChainOfFollowersGoesWithTheFreeJointAtItsEnd) {
  const std::string chained =
      test::replaced(test::kManyKinds, "lower_limit_m: -0.2",
                     "follows: {joint: follower, ratio: 0.5, offset_m: 0.01}, lower_limit_m: -0.2");
  const ArmModel model = readSecond(chained);
  EXPECT_EQ(model.joints[0].leader, 2);
  EXPECT_NEAR(model.joints[0].coupling_ratio, 0.3, 1e-15);
  EXPECT_NEAR(model.joints[0].coupling_offset, 0.06, 1e-15);
  EXPECT_NEAR(model.joints[2].upper_limit, (0.3 - 0.06) / 0.3, 1e-12);
  const std::string ring = test::replaced(chained, "follows: {joint: hinge", "follows: {joint: slide");
  EXPECT_THAT(test::errorOf([&] { readSecond(ring); }), HasSubstr("leads back to itself"));
}

struct Refused {
  const char* what;
  const char* with;
  const char* sentence;
};

class RefusedSecondArm : public testing::TestWithParam<Refused> {};

TEST_P(RefusedSecondArm, InOneSentence) {
  const auto [what, with, sentence] = GetParam();
  const std::string text = test::replaced(test::kManyKinds, what, with);
  ASSERT_NE(text, test::kManyKinds);
  EXPECT_THAT(test::errorOf([&] { readSecond(text); }), AllOf(StartsWith("2: a.yaml:"), HasSubstr(sentence)));
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedSecondArm,
    testing::Values(
        Refused{"simgap/arm/2", "simgap/arm/1", "found 'capsule', expected one of"},
        Refused{"{over: ball, body: base}", "{over: bell, body: base}", "found 'bell', expected the name of a surface"},
        Refused{"{over: ball, body: base}", "{over: ball, body: moon}", "found 'moon', expected the name of a body"},
        Refused{"      - {body: upper, point_m: [-0.01, 0.03, -0.05]}\n", "      - {pulley: 2}\n",
                "found a pulley next to a surface, expected a point"},
        Refused{"{pulley: 2}", "{pulley: 0}", "expected a number > 0"},
        Refused{"name: ball, type: spherical", "name: ball, type: spheric",
                "found 'spheric', expected one of prismatic, revolute, spherical, fixed"},
        Refused{"side_m: [0, 0.05, -0.2]", "side_m: [0, 0.005, -0.2]", "mm inside of 'elbow_roll', of radius 0.015 m"},
        Refused{"point_m: [0, 0.03, -0.16]", "point_m: [0, 0.001, -0.2]",
                "mm inside of 'elbow_roll', of radius 0.015 m"},
        Refused{"point_m: [0, 0.03, -0.16]", "point_m: [-0.01, 0.03, -0.05]", "the same point as the one before it"},
        Refused{"joint: follower, radius", "joint: ball, radius",
                "'ball' is spherical, expected a joint with one axis"},
        Refused{"kind: spring", "kind: sprung",
                "found 'sprung', expected one of constant-force, joint-motor, joint-servo, ligament, line-servo, "
                "pneumatic-muscle, spring"},
        Refused{"kind: constant-force\n    attachments: [{joint: hinge, radius_m: 0.02}, {joint: slide, ratio: 0.5}]\n",
                "kind: joint-motor\n    joint: ball\n", "'ball' is spherical, expected a joint with one axis"},
        Refused{"kind: constant-force\n    attachments: [{joint: hinge, radius_m: 0.02}, {joint: slide, ratio: 0.5}]\n",
                "kind: joint-servo\n    joint: slide\n", "'slide' slides, expected a joint that turns"},
        Refused{"kind: constant-force\n    attachments: [{joint: hinge, radius_m: 0.02}, {joint: slide, ratio: 0.5}]\n",
                "kind: joint-motor\n    joint: knee\n", "found 'knee', expected the name of a joint"},
        Refused{"side_m: [0, 0.05, -0.2]}", "side_body: moon, side_m: [0, 0.05, -0.2]}",
                "found 'moon', expected the name of a body"},
        Refused{"side_m: [0, 0.05, -0.2]}", "side_body: lower, side_m: [0, 0.01, 0]}",
                "mm inside of 'elbow_roll', of radius 0.015 m"},
        Refused{"point_m: [0.02, 0.03, -0.04]", "point_m: [0.02, .nan, -0.04]", "expected a finite number"},
        Refused{"lower_limit_rad: -0.5, upper_limit_rad: 2.0", "lower_limit_rad: 2.5, upper_limit_rad: 2.0",
                "lower_limit_rad 2.5 is above upper_limit_rad 2"},
        Refused{"{body: upper, point_m: [0.02, 0.03, -0.04]}", "{body: carriage, point_m: [0.02, 0.03, -0.04]}",
                "both ends are on the same body"},
        Refused{"follows: {joint: hinge", "follows: {joint: follower", "leads back to itself"},
        Refused{"ratio: 0.6", "ratio: 0", "found 0, expected another number"},
        Refused{"inertia_kg_m2: [2e-5, 2e-5, 1e-5]", "inertia_kg_m2: [9e-5, 2e-5, 1e-5]", "none above the sum"},
        Refused{"parent_orientation: [0.96, 0.28, 0, 0]", "parent_orientation: [0.96, 0.5, 0, 0]", "length 1.08"},
        Refused{"lower_limit_m: -0.2", "lower_limit_rad: -0.2", "lower_limit_rad: unit 'rad' is of another kind"},
        Refused{"parent: tip, child: nail", "parent: tip, child: lower", "closed loops are not modelled"},
        Refused{"type: prismatic, parent: base", "type: prismatic, parent: tip", "hangs on a circle of joints"}));

}  // namespace
}  // namespace simgap
