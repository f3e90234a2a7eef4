// A weight beside the one a pendulum's bench knows: what pulls with the known one, k_a makes up for, and what pulls
// across it is named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "prepared_logs.h"

namespace simgap {
namespace {

using testing::ElementsAre;

constexpr double kBob = 0.5 * 9.81 * 0.2, kBobInertia = 0.5 * 0.2 * 0.2;  // of the known bob [N m], [kg m2]

/// Swings, and a bracket of `bracket` N m hangs `angle` rad from the bob. \returns what diagnose says of it
Diagnosis diagnoseBracket(double bracket, double angle) {
  return test::diagnosePendulum(0.2, 1.0, [&](double theta, double velocity, double acceleration) {
    const double weights = kBob * std::sin(theta) + bracket * std::sin(theta - angle);
    return weights + kBobInertia * acceleration + std::copysign(0.12, velocity) + 0.05 * velocity;
  });
}

TEST(JointGravity, OfABracketBesideAPendulumsBobIsWhatPullsAcross) {
  const Diagnosis found = diagnoseBracket(0.2, 1.2);
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "joint-gravity") << found.sentence;
  EXPECT_EQ(found.causes[0].form, "across");
  EXPECT_THAT(found.causes[0].ambiguous_with, ElementsAre());
  // k_a takes what pulls along: everything is seen in units of 1 + b cos(angle) / M.
  const double along = 1.0 + 0.2 * std::cos(1.2) / kBob;
  ASSERT_FALSE(found.causes[0].parameters.empty());
  EXPECT_EQ(found.causes[0].parameters[0].name, "mgl_across");
  EXPECT_NEAR(found.causes[0].parameters[0].value, -0.2 * std::sin(1.2) / along,
              4.0 * found.causes[0].parameters[0].sd + 0.002);
}

TEST(JointGravity, OfABracketThatHangsWithTheBobIsItsMass) {
  EXPECT_THAT(diagnoseBracket(0.2, 0.0).causes, ElementsAre()) << "k_a makes up for it";
}

}  // namespace
}  // namespace simgap
