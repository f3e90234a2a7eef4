// The global search of separable problems, against sums over all rows and against plain scans.
#include "simgap/optimize/separable.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "simgap/fit/actuators/stribeck_moments.h"

namespace simgap::test {
namespace {

/// Rows of a friction-like model: 1, a static and a sliding column, and a target.
struct Rows {
  Eigen::ArrayXd log_speed;
  Eigen::ArrayXXd x;

  explicit Rows(Eigen::Index count, double noise = 1.0, std::uint64_t seed = 1) : log_speed(count), x(count, 4) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(1e-3, 100.0);
    for (Eigen::Index i = 0; i < count; ++i) {
      log_speed[i] = std::log(uniform(random));
      x(i, 0) = 1.0;
      x(i, 1) = x(i, 2) = i % 2 == 0 ? 1.0 : -1.0;
      x(i, 3) = 2.0 + x(i, 1) * (1.0 + 0.5 * std::exp(-std::exp(log_speed[i]) / 10.0)) + noise * normal(random);
    }
  }

  static std::vector<FrictionShape> shapes() {
    return {FrictionShape::kAlways, FrictionShape::kStatic, FrictionShape::kSliding, FrictionShape::kAlways};
  }

  Eigen::MatrixXd gram(double v_s, double delta) const {
    Eigen::MatrixXd z = x.matrix();
    for (Eigen::Index i = 0; i < z.rows(); ++i) {
      const double exponent = std::pow(std::exp(log_speed[i]) / v_s, delta);
      z(i, 1) *= std::exp(-exponent);
      z(i, 2) *= -std::expm1(-exponent);
    }
    return z.transpose() * z;
  }

  StribeckMoments moments() const {
    StribeckMoments sums(shapes(), log_speed);
    sums.add(log_speed, x);
    return sums;
  }
};

TEST(StribeckMoments, AreExactForFewRows) {
  const Rows rows(400);
  const StribeckMoments moments = rows.moments();
  for (const auto& [v_s, delta] : {std::pair{0.01, 0.1}, {3.0, 1.2}, {40.0, 5.0}, {40.0, 20.0}, {900.0, 2.0}}) {
    const Eigen::MatrixXd expected = rows.gram(v_s, delta);
    EXPECT_LT((moments.gram(v_s, delta) - expected).norm(), 3e-5 * expected.norm()) << v_s << " " << delta;
  }
}

TEST(StribeckMoments, AreCloseForManyRows) {
  const Rows rows(30000);
  const StribeckMoments moments = rows.moments();
  for (const auto& [v_s, delta] : {std::pair{3.0, 1.2}, {40.0, 5.0}, {40.0, 20.0}}) {
    const Eigen::MatrixXd expected = rows.gram(v_s, delta);
    EXPECT_LT((moments.gram(v_s, delta) - expected).norm(), 1e-4 * expected.norm()) << v_s << " " << delta;
  }
}

TEST(StribeckMoments, PartsAddUp) {
  const Rows rows(500);
  StribeckMoments all = rows.moments(), part(Rows::shapes(), rows.log_speed), rest = all;
  part.add(rows.log_speed.head(200), rows.x.topRows(200));
  rest.add(part, -1.0);
  StribeckMoments again = rest;
  again.add(part, 1.0);
  const Eigen::MatrixXd whole = all.gram(5.0, 2.0);
  EXPECT_LT((again.gram(5.0, 2.0) - whole).norm(), 1e-12 * whole.norm());
  EXPECT_LT((rest.gram(5.0, 2.0) + part.gram(5.0, 2.0) - whole).norm(), 1e-12 * whole.norm());
}

/// Noise only: every gap between rows makes a valley of its own.
SeparableProblem noisyProblem(const StribeckMoments& moments) {
  SeparableProblem problem;
  problem.linear = {{"gain"}, {"static"}, {"sliding"}};
  const auto step = [](std::span<const double> p) { return 0.4 / p[1]; };
  problem.nonlinear = {{"v_s", 1e-3, 1e3, true, 48, step}, {"delta", 0.05, 20.0, true, 20}};
  problem.gram = [&moments](std::span<const double> p) { return moments.gram(p[0], p[1]); };
  return problem;
}

TEST(SeparableSearch, FindsTheLowestOfManyNarrowValleys) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const StribeckMoments moments = Rows(120, 1.0, seed).moments();
    const SeparableProblem problem = noisyProblem(moments);
    const SeparableResult found = searchSeparable(problem);
    double lowest = found.minima[0].linear.cost;
    std::vector<double> at;
    for (int j = 0; j <= 60; ++j) {
      const double delta = 0.05 * std::pow(400.0, j / 60.0);
      for (int i = 0; i <= 2000; ++i) {
        const double v_s = 1e-3 * std::pow(1e6, i / 2000.0);
        const double cost = solveBounded(moments.gram(v_s, delta), problem.linear).cost;
        if (cost < lowest) lowest = cost, at = {v_s, delta};
      }
    }
    EXPECT_LE(found.minima[0].linear.cost, lowest * (1.0 + 1e-12))
        << "seed " << seed << ": lower at " << testing::PrintToString(at);
  }
}

TEST(SeparableSearch, ProfileHasTheShapeOfItsAxes) {
  const StribeckMoments moments = Rows(300).moments();
  const SeparableProblem problem = noisyProblem(moments);
  const SeparableResult found = searchSeparable(problem);
  ASSERT_EQ(found.profile.axes.size(), 2u);
  ASSERT_EQ(found.profile.cost.size(), 48u * 20u);
  EXPECT_GT(found.starts, found.profile.cost.size());
  for (const auto& [i, j] : {std::pair{0, 0}, {7, 3}, {30, 19}, {47, 0}, {47, 19}}) {
    const double v_s = found.profile.axes[0][i];
    const double delta = found.profile.axes[1][j];
    EXPECT_DOUBLE_EQ(found.profile.cost[i * 20 + j], solveBounded(moments.gram(v_s, delta), problem.linear).cost);
  }
  EXPECT_LE(found.minima[0].linear.cost, std::ranges::min(found.profile.cost));
}

TEST(SeparableSearch, SolvesProblemsWithoutNonlinearTerms) {
  const Rows rows(50);
  SeparableProblem problem;
  problem.linear = {{"a"}, {"b", -10.0, 10.0}, {"c"}};
  problem.gram = [&](std::span<const double>) { return rows.gram(1.0, 1.0); };
  const SeparableResult found = searchSeparable(problem);
  ASSERT_EQ(found.minima.size(), 1u);
  EXPECT_EQ(found.starts, 1u);
  EXPECT_DOUBLE_EQ(found.minima[0].linear.cost, solveBounded(rows.gram(1.0, 1.0), problem.linear).cost);
}

}  // namespace
}  // namespace simgap::test
