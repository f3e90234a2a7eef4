#include "simgap/model/arm/kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace simgap {
namespace {

using Eigen::Vector3d;
constexpr double kQuarter = std::numbers::pi / 2;

// Upper arm of 0.3 m on a ball joint at (0, 0, 1), forearm on a hinge about x at its end; a palm beside the forearm.
ArmModel arm() {
  ArmModel model;
  model.bodies = {{"torso", true, {}, {}}, {"upper", false, {}, {}}, {"fore", false, {}, {}}, {"palm", false, {}, {}}};
  const auto joint = [](const char* name, JointType type, int parent, int child, const Vector3d& at) {
    Joint made;
    made.name = name;
    made.type = type;
    made.parent = parent;
    made.child = child;
    made.parent_position = at;
    return made;
  };
  Joint shoulder = joint("shoulder", JointType::kSpherical, 0, 1, {0, 0, 1});
  shoulder.child_position = {0, 0, 0.1};
  const Joint elbow = joint("elbow", JointType::kRevolute, 1, 2, {0, 0, -0.2});
  Joint wrist = joint("wrist", JointType::kRevolute, 1, 3, {0.05, 0, 0});
  wrist.axis = Vector3d::UnitZ();
  model.joints = {shoulder, elbow, wrist};
  return model;
}

std::vector<JointPosition> positions(const Eigen::Quaterniond& shoulder, double elbow, double wrist) {
  return {{shoulder, 0.0}, {Eigen::Quaterniond::Identity(), elbow}, {Eigen::Quaterniond::Identity(), wrist}};
}

void expectNear(const Vector3d& a, const Vector3d& b) {
  EXPECT_NEAR((a - b).norm(), 0.0, 1e-15) << "found " << a.transpose() << ", expected " << b.transpose();
}

TEST(Kinematics, HangsStraightAtIdentity) {
  const auto bodies = bodiesInWorld(arm(), positions(Eigen::Quaterniond::Identity(), 0, 0));
  ASSERT_EQ(bodies.size(), 4u);
  expectNear(bodies[0] * Vector3d(1, 2, 3), {1, 2, 3});
  expectNear(bodies[1].origin, {0, 0, 0.9});
  expectNear(bodies[2] * Vector3d(0, 0, -0.25), {0, 0, 0.45});
  expectNear(bodies[3].origin, {0.05, 0, 0.9});
}

TEST(Kinematics, TurnsByTheRightHandRule) {
  // The elbow turns about x: the forearm, which hangs along -z, comes up along +y.
  const auto bent = bodiesInWorld(arm(), positions(Eigen::Quaterniond::Identity(), kQuarter, kQuarter));
  expectNear(bent[2] * Vector3d(0, 0, -0.25), {0, 0.25, 0.7});
  expectNear(bent[3] * Vector3d(1, 0, 0), {0.05, 1, 0.9});
}

TEST(Kinematics, TurnsEverythingBehindAJointAboutItsPoint) {
  // The shoulder turns about y: what hangs along -z comes up along -x, and the elbow's axis x points along -z.
  const Eigen::Quaterniond about_y(Eigen::AngleAxisd(kQuarter, Vector3d::UnitY()));
  const auto bodies = bodiesInWorld(arm(), positions(about_y, kQuarter, 0));
  expectNear(bodies[1] * Vector3d(0, 0, 0.1), {0, 0, 1});
  expectNear(bodies[1] * Vector3d(0, 0, -0.2), {-0.3, 0, 1});
  expectNear(bodies[2].origin, {-0.3, 0, 1});
  expectNear(bodies[2] * Vector3d(0, 0, -0.25), {-0.3, 0.25, 1});
}

TEST(Kinematics, TheSignOfAQuaternionDoesNotMatter) {
  const Eigen::Quaterniond q(0.1, 0.7, -0.5, 0.5);
  const Eigen::Quaterniond unit = q.normalized();
  const Eigen::Quaterniond other(-unit.w(), -unit.x(), -unit.y(), -unit.z());
  const auto a = bodiesInWorld(arm(), positions(unit, 0.4, 0.1));
  const auto b = bodiesInWorld(arm(), positions(other, 0.4, 0.1));
  for (std::size_t i = 0; i < a.size(); ++i) expectNear(a[i] * Vector3d(1, 2, 3), b[i] * Vector3d(1, 2, 3));
}

TEST(Kinematics, StartsAtIdentityAndNearThreeTenthsOfARadian) {
  ArmModel model = arm();
  model.joints[1].lower_limit = 0.5;
  model.joints[1].upper_limit = 1.0;
  model.joints[2].upper_limit = -0.1;
  const auto start = startPosition(model);
  EXPECT_EQ(start[0].rotation.coeffs(), Eigen::Quaterniond::Identity().coeffs());
  EXPECT_EQ(start[1].angle, 0.5);
  EXPECT_EQ(start[2].angle, -0.1);
  EXPECT_EQ(startPosition(arm())[1].angle, 0.3);
}

TEST(Kinematics, MeasuresAMuscleAlongAStraightLine) {
  const auto bodies = bodiesInWorld(arm(), positions(Eigen::Quaterniond::Identity(), kQuarter, 0));
  Muscle muscle;
  muscle.attachments = {Attachment{0, {0, 0.25, 1.0}},
                        Attachment{2, {0.4, 0, -0.25}}};  // in the world (0.4, 0.25, 0.7)
  EXPECT_NEAR(muscleLength(muscle, bodies), 0.5, 1e-15);
  std::swap(muscle.attachments[0], muscle.attachments[1]);
  EXPECT_NEAR(muscleLength(muscle, bodies), 0.5, 1e-15);
}

}  // namespace
}  // namespace simgap
