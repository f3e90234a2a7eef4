// Surrogates keep the colour of a signal and lose its place.
#include "diagnose/logs/placebos.h"

#include <gtest/gtest.h>

#include <cmath>

namespace simgap {
namespace {

Eigen::VectorXd slowSignal(Eigen::Index n) {
  Eigen::VectorXd x(n);
  const Eigen::ArrayXd i = Eigen::ArrayXd::LinSpaced(n, 0.0, static_cast<double>(n - 1));
  x = 2.0 + (0.05 * i).sin() + 0.5 * (0.113 * i + 1.0).sin();
  return x;
}

double alike(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::ArrayXd x = a.array() - a.mean(), y = b.array() - b.mean();
  return (x * y).sum() / std::sqrt(x.square().sum() * y.square().sum());
}

TEST(Placebos, KeepMeanSizeAndColour) {
  const Eigen::VectorXd x = slowSignal(4000), y = phaseRandomised(x, 3, 1);
  ASSERT_EQ(y.size(), x.size());
  EXPECT_NEAR(y.mean(), x.mean(), 1e-9);
  const auto power = [](const Eigen::VectorXd& v) { return (v.array() - v.mean()).square().mean(); };
  EXPECT_NEAR(power(y), power(x), 1e-6 * power(x));
  // As smooth as it was: neighbours are as alike.
  const auto neighbours = [](const Eigen::VectorXd& v) { return alike(v.head(v.size() - 1), v.tail(v.size() - 1)); };
  EXPECT_NEAR(neighbours(y), neighbours(x), 0.01);
}

TEST(Placebos, BelongToNoMotion) {
  const Eigen::VectorXd x = slowSignal(4000);
  double largest = 0.0;
  for (std::uint32_t draw = 0; draw < 20; ++draw) {
    largest = std::max(largest, std::abs(alike(x, phaseRandomised(x, draw, 1))));
  }
  EXPECT_LT(largest, 0.999);
  EXPECT_NE(phaseRandomised(x, 0, 1), phaseRandomised(x, 1, 1));
  EXPECT_EQ(phaseRandomised(x, 0, 1), phaseRandomised(x, 0, 1));
}

TEST(Placebos, TakeAnyLength) {
  for (const Eigen::Index n : {2, 7, 101, 997}) EXPECT_TRUE(phaseRandomised(slowSignal(n), 0, 1).allFinite()) << n;
}

}  // namespace
}  // namespace simgap
