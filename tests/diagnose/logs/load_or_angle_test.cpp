// A pendulum's cable hangs straight where its weight does: friction by the bend and friction by the load say the same.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "prepared_logs.h"

namespace simgap {
namespace {

constexpr double kWeight = 0.5 * 9.81 * 0.2;  // [N m]

/// What diagnose says of a pendulum that swings by up to 1.4 rad times `swing`, and whose dry friction is that of `dry`
/// [N m] at an angle.
template <typename Dry>
Diagnosis diagnoseFriction(double swing, Dry dry) {
  return test::diagnosePendulum(0.0, swing, [&](double theta, double velocity, double acceleration) {
    const double friction = std::copysign(dry(theta), velocity) + 0.05 * velocity;
    return kWeight * std::sin(theta) + 0.02 * acceleration + friction;
  });
}

TEST(LoadOrAngle, ABendOfAnotherLawThanTheCataloguesIsNotCalledTheLoadAlone) {
  const Diagnosis found = diagnoseFriction(1.0, [](double theta) { return 0.06 + 0.12 * kWeight * std::abs(theta); });
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "load-dependence") << found.sentence;
  EXPECT_THAT(found.causes[0].ambiguous_with, testing::ElementsAre("bend-friction"));
}

/// Beyond a quarter turn the weight pulls less and the cable is bent more.
TEST(LoadOrAngle, TheLoadIsNamedAloneWhereItTellsClearlyMore) {
  const Diagnosis found =
      diagnoseFriction(1.7, [](double theta) { return 0.06 + 0.12 * kWeight * std::abs(std::sin(theta)); });
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "load-dependence") << found.sentence;
  EXPECT_THAT(found.causes[0].ambiguous_with, testing::IsEmpty());
}

}  // namespace
}  // namespace simgap
