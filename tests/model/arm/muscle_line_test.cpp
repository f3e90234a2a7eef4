#include "simgap/model/arm/muscle_line.h"

#include <gtest/gtest.h>

#include "simgap/model/arm/arm_effect.h"
#include "support/arms.h"

namespace simgap {
namespace {

using Eigen::Vector3d;

/// A pendulum on a hinge in the origin, with a line from above it to 0.2 m below.
ArmModel straightArm() {
  ArmModel model = test::pendulum();
  test::addMuscle(model, {0, {0.0, 0.05, 0.2}}, {1, {0.0, 0.05, -0.2}}, 0.1);
  return model;
}

TEST(MuscleLine, RunsStraightThroughItsAttachments) {
  const ArmModel model = straightArm();
  const std::vector<JointPosition> bent{test::hingeAt(0.5)};
  const auto bodies = bodiesInWorld(model, bent);
  const std::vector<Vector3d> line = muscleLine(model, 0, bodies);
  ASSERT_EQ(line.size(), 2u);
  EXPECT_EQ(line[0], Vector3d(0.0, 0.05, 0.2));
  EXPECT_TRUE(line[1].isApprox(Eigen::AngleAxisd(0.5, Vector3d::UnitX()) * Vector3d(0.0, 0.05, -0.2), 1e-14));
}

// Larger than the nearer end is away from the joint: what statics take for it is drawn.
TEST(MuscleLine, ASphereThatReachesBeyondTheLinesEndIsDrawnAsLargeAsItActs) {
  ArmModel model = straightArm();
  EffectParameters p{};
  p[0] = 0.3, p[1] = 1.0;
  model.extensions = {makeExtension(*findArmEffect("muscle-wrap"), model.muscles[0].name, p)};
  const std::vector<JointPosition> straight{test::hingeAt(0.0)};
  const std::vector<Vector3d> line = muscleLine(model, 0, bodiesInWorld(model, straight));
  ASSERT_EQ(line.size(), 9u);
  for (const Vector3d& point : line) EXPECT_TRUE(point.allFinite());
  EXPECT_LT(line[4].norm(), line[0].norm());
}

TEST(MuscleLine, TouchesTheSphereItWrapsAroundAndIsAsLongAsTheEffectSays) {
  ArmModel model = straightArm();
  constexpr double kRadius = 0.08;  // more than the 0.05 m at which the line passes
  model.extensions = {{.effect = "muscle-wrap", .target = "", .parameters = {}}};
  model.extensions[0].target = model.muscles[0].name;
  for (const auto& [name, value] : {std::pair{"radius", kRadius}, std::pair{"joint", 1.0}}) {
    Estimate parameter;
    parameter.name = name;
    parameter.value = value;
    model.extensions[0].parameters.push_back(parameter);
  }
  const std::vector<JointPosition> straight{test::hingeAt(0.0)};
  const std::vector<Vector3d> line = muscleLine(model, 0, bodiesInWorld(model, straight));
  ASSERT_EQ(line.size(), 9u);
  for (std::size_t p = 1; p + 1 < line.size(); ++p) EXPECT_NEAR(line[p].norm(), kRadius, 1e-14);
  // Both ends leave along tangents.
  EXPECT_NEAR(line[1].dot(line[1] - line[0]), 0.0, 1e-14);
  EXPECT_NEAR(line[7].dot(line[7] - line[8]), 0.0, 1e-14);
}

}  // namespace
}  // namespace simgap
