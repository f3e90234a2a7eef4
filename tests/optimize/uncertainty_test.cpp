#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "simgap/optimize/uncertainty.h"

namespace simgap {
namespace {

TEST(Uncertainty, APartKeepsItsOwnRowsAndColumns) {
  Uncertainty all;
  for (const char* name : {"a", "b", "c"}) {
    Estimate estimate;
    estimate.name = name;
    all.estimates.push_back(estimate);
  }
  all.covariance.resize(3, 3);
  all.covariance << 1, 2, 3, 2, 5, 6, 3, 6, 9;
  all.correlation = 0.1 * all.covariance;
  all.n_effective = 7.0;
  const Uncertainty part = partOf(all, 1, 3);
  ASSERT_EQ(part.estimates.size(), 2u);
  EXPECT_EQ(part.estimates[0].name, "b");
  EXPECT_EQ(part.covariance, (Eigen::Matrix2d() << 5, 6, 6, 9).finished());
  EXPECT_EQ(part.correlation, 0.1 * part.covariance);
  EXPECT_EQ(part.n_effective, 7.0);
}

/// y = a + b x at an x that hardly varies, with b >= 0 where the rows ask for less.
LeastSquaresProblem nearlyOneSpeed() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  LeastSquaresProblem problem;
  problem.parameters = {{"a", "1", -kInfinity, kInfinity}, {"b", "1", 0.0, kInfinity}};
  problem.chunks = evenChunks(400);
  problem.evaluate = [](std::span<const double> theta, const Block& rows, Eigen::Ref<Eigen::VectorXd> residual,
                        Eigen::Ref<Eigen::MatrixXd>* jacobian) {
    for (std::size_t i = rows.begin; i < rows.end; ++i) {
      const auto at = static_cast<Eigen::Index>(i - rows.begin);
      const double n = static_cast<double>(i), x = 1.0 + 0.02 * std::sin(12.9898 * n);
      const double y = 1.0 - 1.0 * (x - 1.0) + 0.1 * std::sin(78.233 * n * n);
      residual[at] = theta[0] + theta[1] * x - y;
      if (jacobian != nullptr) jacobian->row(at) << 1.0, x;
    }
  };
  return problem;
}

/// y = a + b x through 36 rows whose errors bend to and fro.
LeastSquaresProblem bentRows() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  LeastSquaresProblem problem;
  problem.parameters = {{"a", "1", -kInfinity, kInfinity}, {"b", "1", -kInfinity, kInfinity}};
  problem.chunks = evenChunks(36);
  problem.evaluate = [](std::span<const double> theta, const Block& rows, Eigen::Ref<Eigen::VectorXd> residual,
                        Eigen::Ref<Eigen::MatrixXd>* jacobian) {
    for (std::size_t i = rows.begin; i < rows.end; ++i) {
      const auto at = static_cast<Eigen::Index>(i - rows.begin);
      const double x = static_cast<double>(i) / 36.0;
      residual[at] = theta[0] + theta[1] * x - std::sin(12.0 * x);
      if (jacobian != nullptr) jacobian->row(at) << 1.0, x;
    }
  };
  return problem;
}

TEST(Uncertainty, FewRowsThatBendToAndFroAreAlikeAsLongAsTheyAreOnOneSide) {
  const LeastSquaresProblem problem = bentRows();
  const Uncertainty all = estimateUncertainty(problem, minimise(problem, {0.0, 0.0}).theta, std::vector<int>(36, 0));
  EXPECT_EQ(all.blocks, 0U);
  EXPECT_GT(all.correlation_rows, 4.0);  // a quarter of a period is 4.7 rows
}

TEST(Uncertainty, AnIntervalFollowsANeighbourOnItsBound) {
  const LeastSquaresProblem problem = nearlyOneSpeed();
  const LeastSquaresResult found = minimise(problem, {0.5, 0.5});
  ASSERT_EQ(found.theta[1], 0.0);
  const Uncertainty all = estimateUncertainty(problem, found.theta, std::vector<int>(400, 0));
  const Estimate &a = all.estimates[0], &b = all.estimates[1];
  ASSERT_TRUE(b.at_bound);
  ASSERT_GT(b.upper95, 0.1);
  // With b at the end of its interval a lies lower by as much, and nothing moves it up.
  EXPECT_LE(a.lower95, a.value - 0.99 * b.upper95);
  EXPECT_LT(a.upper95, a.value + 0.05);
  LeastSquaresProblem alone = problem;
  alone.parameters[1].fixed = true;
  const Estimate fixed = estimateUncertainty(alone, found.theta, std::vector<int>(400, 0)).estimates[0];
  EXPECT_NEAR(a.upper95, fixed.upper95, 1e-12);
  EXPECT_GT(a.value - a.lower95, 5.0 * (fixed.value - fixed.lower95)) << "held at its bound b hides what a may be";
}

TEST(Uncertainty, OfWhatActsByItsInverseHasNoUpperEndWhereThatMayBeNone) {
  const ParameterSpec spec{"k", "1", 1e-12, 1e6};
  const auto known = [&](double sd) {
    Estimate k{
        .name = "k", .value = 2.0, .sd = sd, .lower95 = std::max(2.0 - 2.0 * sd, 0.0), .upper95 = 2.0 + 2.0 * sd};
    knowByInverse(2.0, spec, k);
    return k;
  };
  EXPECT_NEAR(known(0.01).lower95, 1.9802, 1e-4);  // 1 / (1/2 + 0.02 / 4): of a small one nearly the same
  EXPECT_NEAR(known(0.01).upper95, 2.0202, 1e-4);
  EXPECT_NEAR(known(0.5).lower95, 4.0 / 3.0, 1e-12);
  EXPECT_NEAR(known(0.5).upper95, 4.0, 1e-12);
  EXPECT_NEAR(known(2.0).lower95, 2.0 / 3.0, 1e-12) << "1/2 + 1, and not down to its bound";
  EXPECT_EQ(known(2.0).upper95, 1e6);
}

}  // namespace
}  // namespace simgap
