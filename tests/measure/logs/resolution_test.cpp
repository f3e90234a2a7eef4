#include "simgap/measure/logs/resolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace simgap {
namespace {

TEST(NoiseLevel, FindsWhiteNoiseUnderSlowMotion) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::vector<double> v;
  for (int i = 0; i < 5000; ++i) v.push_back(10.0 * std::sin(0.01 * i) + 0.2 * normal(random));
  EXPECT_NEAR(noiseLevel(v), 0.2, 0.01);
}

TEST(Quantum, IsTheCountOfAnEncoder) {
  std::vector<double> angle;
  for (int i = 0; i < 1000; ++i) angle.push_back(0.01 * std::round(100.0 * std::sin(0.01 * i)));
  EXPECT_NEAR(quantumOf(angle), 0.01, 1e-12);
  EXPECT_NEAR(noiseLevel(angle), 0.0025, 1e-12);  // a quarter of it, where the motion is slow
  EXPECT_EQ(quantumOf(std::vector<double>(5, 3.0)), 0.0);
}

}  // namespace
}  // namespace simgap
