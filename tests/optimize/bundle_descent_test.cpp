// Descents of functions with kinks, whose minima are known in closed form.
#include "simgap/optimize/bundle_descent.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace simgap::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNone = std::numeric_limits<double>::infinity();

KinkedFunction free(int n) { return {{}, {}, VectorXd::Constant(n, -kNone), VectorXd::Constant(n, kNone)}; }

TEST(BundleDescent, FollowsAKinkToItsLowestPoint) {
  // f = 10 |x - y| + 1/2 (x - 3)^2 + 1/2 y^2: on the kink x = y it is lowest at 1.5. A step of one side's curvature
  // crosses the kink at once.
  KinkedFunction f = free(2);
  f.value = [](const VectorXd& x) {
    return 10.0 * std::abs(x[0] - x[1]) + 0.5 * (x[0] - 3.0) * (x[0] - 3.0) + 0.5 * x[1] * x[1];
  };
  f.linearise = [](const VectorXd& x, MatrixXd& n, VectorXd& g) {
    n = MatrixXd::Identity(2, 2);
    const double side = x[0] > x[1] ? 10.0 : -10.0;
    g = Eigen::Vector2d(side + x[0] - 3.0, -side + x[1]);
  };
  const BundleDescent found = descendBundle(f, Eigen::Vector2d(-4.0, 7.0), 1e-8);
  EXPECT_NEAR(found.x[0], 1.5, 1e-3);
  EXPECT_NEAR(found.x[1], 1.5, 1e-3);
  EXPECT_NEAR(found.value, 2.25, 1e-4);
}

TEST(BundleDescent, GoesOnWhereTheCostIsOnOneSideOnly) {
  // A line that is slack for x < 0 and stiff beyond, whose end wants to be pulled: 1/2 (x - 2)^2 + 200 max(0, x)^2 +
  // 3 max(0, x), lowest at x = 0 where slopes are -2 and +1; y is free of it: 1/2 (y - 5)^2.
  KinkedFunction f = free(2);
  f.value = [](const VectorXd& x) {
    const double taut = std::max(0.0, x[0]);
    return 0.5 * (x[0] - 2.0) * (x[0] - 2.0) + 200.0 * taut * taut + 3.0 * taut + 0.5 * (x[1] - 5.0) * (x[1] - 5.0);
  };
  f.linearise = [](const VectorXd& x, MatrixXd& n, VectorXd& g) {
    const bool taut = x[0] > 0.0;
    n = MatrixXd::Identity(2, 2);
    n(0, 0) += taut ? 400.0 : 0.0;
    g = Eigen::Vector2d(x[0] - 2.0 + (taut ? 400.0 * x[0] + 3.0 : 0.0), x[1] - 5.0);
  };
  const BundleDescent found = descendBundle(f, Eigen::Vector2d(-0.001, 0.0), 1e-6);
  EXPECT_NEAR(found.x[0], 0.0, 1e-3);
  EXPECT_NEAR(found.x[1], 5.0, 1e-3);
}

TEST(BundleDescent, KeepsWithinBounds) {
  KinkedFunction f = free(2);
  f.upper[0] = 1.0;
  f.value = [](const VectorXd& x) { return (x - Eigen::Vector2d(3.0, 1.0)).squaredNorm() + x[0] * x[1]; };
  f.linearise = [](const VectorXd& x, MatrixXd& n, VectorXd& g) {
    n = Eigen::Matrix2d{{2.0, 1.0}, {1.0, 2.0}};
    g = 2.0 * (x - Eigen::Vector2d(3.0, 1.0)) + Eigen::Vector2d(x[1], x[0]);
  };
  const BundleDescent found = descendBundle(f, Eigen::Vector2d::Zero(), 1e-10);
  EXPECT_NEAR(found.x[0], 1.0, 1e-9);
  EXPECT_NEAR(found.x[1], 0.5, 1e-6);  // 2 (y - 1) + x = 0
}

TEST(BundleDescent, IsAStepOfNewtonWhereThereIsNoKink) {
  KinkedFunction f = free(1);
  f.value = [](const VectorXd& x) { return 2.0 * (x[0] - 1.0) * (x[0] - 1.0); };
  f.linearise = [](const VectorXd& x, MatrixXd& n, VectorXd& g) {
    n = MatrixXd::Constant(1, 1, 4.0);
    g = VectorXd::Constant(1, 4.0 * (x[0] - 1.0));
  };
  const BundleDescent found = descendBundle(f, VectorXd::Constant(1, -6.0), 1e-9);
  EXPECT_NEAR(found.x[0], 1.0, 1e-9);
  EXPECT_EQ(found.steps, 1);
}

TEST(BundleDescent, StaysWhereTheFunctionEnds) {
  KinkedFunction f = free(1);
  f.value = [](const VectorXd& x) { return x[0] < 0.0 ? kNone : x[0]; };
  f.linearise = [](const VectorXd&, MatrixXd& n, VectorXd& g) {
    n = MatrixXd::Identity(1, 1);
    g = VectorXd::Ones(1);
  };
  const BundleDescent found = descendBundle(f, VectorXd::Constant(1, 0.5), 1e-6);
  EXPECT_GE(found.x[0], 0.0);
  EXPECT_TRUE(std::isfinite(found.value));
  EXPECT_TRUE(std::isinf(descendBundle(f, VectorXd::Constant(1, -1.0), 1e-6).value));
}

}  // namespace
}  // namespace simgap::test
