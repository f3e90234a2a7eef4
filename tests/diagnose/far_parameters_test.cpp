// What a fit puts far from where it was measured by hand is said, whether a cause was named or not.
#include "diagnose/far_parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/rig.h"

namespace simgap {
namespace {

TEST(FarParameters, AreSaidWithTheirDistanceFromTheHandMeasurement) {
  const ParameterSpace space = test::paperParameters(test::recordRig(1).model);
  const ScaledParameters scaled(space);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(scaled.size() + 1);  // a motion has a clock behind them
  z[3] = -4.2, z[5] = 3.4, z[scaled.size() - 1] = 9.0, z[scaled.size()] = 20.0;
  const auto said = farParameters(scaled, space, z, scaled.size() - 1);  // the last one is a cause's
  ASSERT_TRUE(scaled.hasPrior(3) && scaled.hasPrior(5));
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], testing::StartsWith(space.parameters()[3].name + " lies 4.2 standard deviations"));
}

}  // namespace
}  // namespace simgap
