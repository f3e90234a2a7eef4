// What a change of an arm, stated in physical words, makes of its model.
#include "simgap/model/arm/arm_change.h"

#include <gtest/gtest.h>

#include "simgap/core/yaml.h"
#include "support/arms.h"

namespace simgap {
namespace {

using Eigen::Vector3d;

ArmChanges changes(const std::string& list, const ArmModel& model) {
  return ArmChanges::read(YamlNode::parse("format: simgap/change/1\nchanges: [" + list + "]\n", "c.yaml"), model);
}

// Of a body with a point mass the books say: the masses, their mean place, and Steiner's term of the reduced mass.
TEST(ArmChange, AMassThatIsHungOnTurnsWithTheBody) {
  ArmModel model = test::pendulum();
  const MassProperties before = massProperties(model.bodies[1]);
  changes("{kind: mass, body: " + model.bodies[1].name + ", at_m: [0.02, 0, -0.3], mass_kg: 0.5}", model).apply(model);
  const MassProperties after = massProperties(model.bodies[1]);
  const Vector3d place(0.02, 0.0, -0.3), way = place - before.centre_of_mass;
  EXPECT_NEAR(after.mass, before.mass + 0.5, 1e-12);
  EXPECT_LT((after.centre_of_mass - (before.mass * before.centre_of_mass + 0.5 * place) / after.mass).norm(), 1e-12);
  const double reduced = before.mass * 0.5 / after.mass;
  const Eigen::Matrix3d expected =
      before.inertia + reduced * (way.squaredNorm() * Eigen::Matrix3d::Identity() - way * way.transpose());
  EXPECT_LT((after.inertia - expected).norm(), 1e-12);
  // Taken off again, it is the body that it was.
  changes("{kind: mass, body: " + model.bodies[1].name + ", at_m: [0.02, 0, -0.3], mass_kg: -0.5}", model).apply(model);
  EXPECT_LT((massProperties(model.bodies[1]).inertia - before.inertia).norm(), 1e-12);
  EXPECT_LT((massProperties(model.bodies[1]).centre_of_mass - before.centre_of_mass).norm(), 1e-12);
}

}  // namespace
}  // namespace simgap
