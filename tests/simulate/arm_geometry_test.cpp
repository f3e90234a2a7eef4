// The tables behind the arm's view, on an arm whose every coordinate is worked out by hand.
#include "simgap/simulate/arm_geometry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "report/result_folder.h"
#include "simgap/model/arm/arm_effect.h"

namespace simgap {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;

/// A post with a hinge about x at 1 m; a rod hangs from it; a cord from the post's top to the rod's end.
ArmModel hingeArm() {
  ArmModel model;
  model.bodies = {{"post", true, {}, {}}, {"rod", false, {}, {}}};
  Part bone;
  bone.name = "bone";
  bone.radius = 0.02;
  bone.length = 0.5;
  bone.position = {0.0, 0.0, -0.25};
  model.bodies[1].parts = {bone};
  Joint joint;
  joint.name = "hinge";
  joint.type = JointType::kRevolute;
  joint.parent = 0;
  joint.child = 1;
  joint.parent_position = {0.0, 0.0, 1.0};
  model.joints = {joint};
  Muscle cord;
  cord.name = "cord";
  cord.attachments = {Attachment{0, {0.0, 0.0, 2.0}}, Attachment{1, {0.0, 0.0, -0.5}}};
  cord.shock_cord = {0.1, 1000.0, 5.0};
  model.muscles = {cord};
  return model;
}

class ArmGeometry : public ::testing::Test {
 protected:
  ArmGeometry() : folder_(result()) {
    pose_.joints = {{Eigen::Quaterniond::Identity(), 0.0}};
    poses_.poses = {pose_, pose_};
    poses_.poses[1].name = "invalid";
    PoseOutcome steady;
    steady.status = PoseStatus::kSteady;
    steady.joints = {{Eigen::Quaterniond::Identity(), std::numbers::pi / 2}};
    steady.cord_expansion = {0.3};
    steady.shafts = {0.0};
    PoseOutcome invalid;
    invalid.status = PoseStatus::kNotSteady;
    outcomes_ = {steady, invalid};
    const ReplayedSet replay{"replayed", "simulated", model_, poses_, outcomes_};
    writeArmGeometry({&replay, 1}, folder_.directory());
  }
  static Json result() { return {{"format", "simgap/validate/1"}}; }
  CsvTable table(const char* name) const { return CsvTable::load(folder_.directory().file(name)); }

  ArmModel model_ = hingeArm();
  Pose pose_{"turned", {0.0}, {}, 1, {0.0}};
  PoseSet poses_;
  std::vector<PoseOutcome> outcomes_;
  test::ResultFolder folder_;
};

TEST_F(ArmGeometry, PlacesBodiesWhereTheyWereMeasuredAndSimulated) {
  const CsvTable bodies = table("arm_bodies.csv");
  EXPECT_THAT(bodies.text("pose"), ElementsAre("turned", "turned", "turned", "turned", "invalid", "invalid"));
  EXPECT_THAT(bodies.text("state"),
              ElementsAre("measured", "measured", "simulated", "simulated", "measured", "measured"));
  EXPECT_THAT(bodies.text("body"), ElementsAre("post", "rod", "post", "rod", "post", "rod"));
  EXPECT_THAT(bodies.quantity("z", "m"), ElementsAre(0.0, 1.0, 0.0, 1.0, 0.0, 1.0));
  // A quarter turn about x: (cos 45°, sin 45°, 0, 0).
  EXPECT_NEAR(bodies.quantity("qw", "")[3], std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(bodies.quantity("qx", "")[3], std::sqrt(0.5), 1e-12);
  EXPECT_EQ(bodies.quantity("qw", "")[1], 1.0);
}

TEST_F(ArmGeometry, DrawsMusclesWhereTheySimulatedWithTheirTension) {
  const CsvTable muscles = table("arm_muscles.csv");
  ASSERT_EQ(muscles.rows(), 2u) << "two points of one steady pose";
  // The rod's end (0, 0, -0.5) turned by 90° about x is (0, 0.5, 0) from the hinge at (0, 0, 1).
  EXPECT_THAT(muscles.quantity("y", "m"), ElementsAre(0.0, DoubleNear(0.5, 1e-12)));
  EXPECT_THAT(muscles.quantity("z", "m"), ElementsAre(2.0, DoubleNear(1.0, 1e-12)));
  EXPECT_NEAR(muscles.quantity("tension", "N")[0], 1000.0 * 0.3 * 0.1, 1e-9);  // k L_SR expansion
}

// A cord that hardens pulls with more than its stiffness: k (x + h x^2).
TEST_F(ArmGeometry, TensionsHoldWhatExtensionsAdd) {
  ArmModel model = hingeArm();
  const ArmEffect& hardening = *findArmEffect("cord-hardening");
  EffectParameters p{};
  p[0] = 0.5;
  model.extensions = {makeExtension(hardening, "cord", p)};
  const ReplayedSet replay{"replayed", "simulated", model, poses_, outcomes_};
  writeArmGeometry({&replay, 1}, folder_.directory());
  const double added = hardening.cord(p, 0.03, model.muscles[0].shock_cord, {}).force;
  ASSERT_GT(added, 1.0);
  EXPECT_NEAR(table("arm_muscles.csv").quantity("tension", "N")[0], 1000.0 * 0.3 * 0.1 + added, 1e-9);
}

// Ends 1 m and 0.5 m from the hinge, a right angle apart: a line round a sphere of 0.48 m touches it, since
// acos(0.48) + acos(0.96) is less than 90°.
TEST_F(ArmGeometry, BendsMusclesRoundTheJointsTheyWrap) {
  constexpr double kRadius = 0.48;
  ArmModel model = hingeArm();
  model.extensions = {{"muscle-wrap", "cord", {{"radius", "m", kRadius, 0.0}, {"joint", "1", 1.0, 0.0}}}};
  const ReplayedSet replay{"replayed", "simulated", model, poses_, outcomes_};
  writeArmGeometry({&replay, 1}, folder_.directory());
  const CsvTable muscles = table("arm_muscles.csv");
  const std::vector<double> y = muscles.quantity("y", "m"), z = muscles.quantity("z", "m");
  ASSERT_GT(y.size(), 4u);
  double length = 0.0;
  for (std::size_t i = 1; i < y.size(); ++i) {
    length += std::hypot(y[i] - y[i - 1], z[i] - z[i - 1]);
    if (i + 1 < y.size()) {
      EXPECT_NEAR(std::hypot(y[i], z[i] - 1.0), kRadius, 1e-12);
    }
  }
  const double arc = std::numbers::pi / 2 - std::acos(0.48) - std::acos(0.96);
  EXPECT_NEAR(length, std::sqrt(1.0 - 0.48 * 0.48) + std::sqrt(0.25 - 0.48 * 0.48) + kRadius * arc, 1e-4);
}

TEST_F(ArmGeometry, ShapesTheBodiesWithBallsAtTheJoints) {
  const CsvTable parts = table("arm_parts.csv");
  EXPECT_THAT(parts.text("part"), ElementsAre("bone", "hinge"));
  EXPECT_THAT(parts.text("shape"), ElementsAre("cylinder", "sphere"));
  EXPECT_THAT(parts.quantity("length", "m"), ElementsAre(0.5, 0.0));
}

}  // namespace
}  // namespace simgap
