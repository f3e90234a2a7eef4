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

TEST(Uncertainty, AThousandTimesItselfIsNoDeviation) {
  // y = a b at b that may stand for a, but for a trifle: a is a scale, c bounded.
  LeastSquaresProblem problem;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  problem.parameters = {{"a", "1", 1e-12, kInfinity}, {"b", "1", 1e-12, kInfinity}, {"c", "1", -1.0, 1.0}};
  problem.chunks = evenChunks(200);
  problem.evaluate = [](std::span<const double> theta, const Block& rows, Eigen::Ref<Eigen::VectorXd> residual,
                        Eigen::Ref<Eigen::MatrixXd>* jacobian) {
    for (std::size_t i = rows.begin; i < rows.end; ++i) {
      const auto at = static_cast<Eigen::Index>(i - rows.begin);
      const double n = static_cast<double>(i), trifle = 1e-6 * std::sin(3.7 * n), slight = 1e-6 * std::cos(5.1 * n);
      residual[at] = theta[0] + (1.0 + trifle) * theta[1] + slight * theta[2] - 2.0 - 0.1 * std::sin(78.233 * n * n);
      if (jacobian != nullptr) jacobian->row(at) << 1.0, 1.0 + trifle, slight;
    }
  };
  const Uncertainty all = estimateUncertainty(problem, std::vector<double>{1.0, 1.0, 0.0}, std::vector<int>(200, 0));
  for (const Estimate& e : all.estimates) {
    EXPECT_FALSE(e.identifiable) << e.name << " " << e.sd;
    EXPECT_TRUE(std::isnan(e.sd) && std::isnan(e.lower95) && std::isnan(e.upper95)) << e.name;
  }
  ASSERT_FALSE(all.findings.empty());
  EXPECT_NE(all.findings[0].find("a, b, c cannot be found"), std::string::npos) << all.findings[0];
}

}  // namespace
}  // namespace simgap
