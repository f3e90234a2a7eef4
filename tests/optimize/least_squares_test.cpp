// The shared engine at bounds.
#include "simgap/optimize/least_squares.h"

#include <gtest/gtest.h>

#include <cmath>

namespace simgap::test {
namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// Rosenbrock's valley y = x^2 as two residuals; the free minimum is (1, 1).
LeastSquaresProblem valley(double x_upper, double y_lower = -kNoBound) {
  LeastSquaresProblem problem;
  problem.parameters = {{"x", "1", -kNoBound, x_upper}, {"y", "1", y_lower, kNoBound}};
  problem.chunks = evenChunks(2);
  problem.evaluate = [](std::span<const double> theta, const Block&, Eigen::Ref<Eigen::VectorXd> residual,
                        Eigen::Ref<Eigen::MatrixXd>* jacobian) {
    residual << 10.0 * (theta[1] - theta[0] * theta[0]), 1.0 - theta[0];
    if (jacobian != nullptr) *jacobian << -20.0 * theta[0], 10.0, -1.0, 0.0;
  };
  return problem;
}

TEST(LeastSquares, FollowsAValleyToABound) {
  for (const double start : {-1.2, 0.0, 0.5, 3.0}) {
    const LeastSquaresResult found = minimise(valley(0.5), {start, 1.0});
    EXPECT_TRUE(found.converged) << found.message;
    EXPECT_EQ(found.theta[0], 0.5);
    EXPECT_NEAR(found.theta[1], 0.25, 1e-7);  // what 1e-13 of the cost leaves open
    EXPECT_NEAR(found.cost, 0.25, 1e-14);
  }
}

TEST(LeastSquares, LeavesABoundThatOnlyTheStartIsOn) {
  const LeastSquaresResult found = minimise(valley(2.0), {2.0, 0.0});
  EXPECT_NEAR(found.theta[0], 1.0, 1e-7);
  EXPECT_NEAR(found.theta[1], 1.0, 1e-7);
}

TEST(LeastSquares, LetsABoundGoOnceTheRestHasMoved) {
  // At the start x is pressed against 2 from below, y = 9 lies beyond its square; y falls to 4, and then x may.
  const LeastSquaresResult found = minimise(valley(2.0), {2.0, 9.0});
  EXPECT_NEAR(found.theta[0], 1.0, 1e-7);
  EXPECT_NEAR(found.cost, 0.0, 1e-12);
}

TEST(LeastSquares, HoldsTwoBoundsAtOnce) {
  const LeastSquaresResult found = minimise(valley(0.5, 0.75), {-1.0, 2.0});
  EXPECT_EQ(found.theta[0], 0.5);
  EXPECT_EQ(found.theta[1], 0.75);
  EXPECT_NEAR(found.cost, 25.25, 1e-12);
}

TEST(LeastSquares, RanksWhatSeveralStartsFound) {
  std::vector<LeastSquaresResult> found(4);
  const double costs[] = {3.0, 1.0, 1.00005, 2.0};
  for (std::size_t i = 0; i < found.size(); ++i) found[i].cost = costs[i];
  EXPECT_EQ(rankMinima(found), 3u);  // 1 and 1.00005 are one
  EXPECT_EQ(found.front().cost, 1.0);
  EXPECT_EQ(found.back().cost, 3.0);
  found.clear();
  EXPECT_EQ(rankMinima(found), 0u);
}

}  // namespace
}  // namespace simgap::test
