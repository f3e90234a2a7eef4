#include "simgap/decode/band_pass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace simgap::test {
namespace {

constexpr double kRate = 256.0;

/// How much of a sine passes, once it has settled.
double passed(double frequency) {
  BandPass filter(4, 7.0, 30.0, kRate);
  double squares = 0.0;
  const int settled = 4096, rows = settled + 25600;
  for (int i = 0; i < rows; ++i) {
    const double out = filter(std::sin(2.0 * std::numbers::pi * frequency * i / kRate));
    if (i >= settled) squares += out * out;
  }
  return std::sqrt(2.0 * squares / 25600.0);
}

/// Butterworth's own words: |H|^2 = 1 / (1 + ((w^2 - w1 w2) / (w (w2 - w1)))^(2 n)), of tangents of half angles.
double expectedOf(double frequency) {
  const auto bent = [](double f) { return std::tan(std::numbers::pi * f / kRate); };
  const double w = bent(frequency), w1 = bent(7.0), w2 = bent(30.0);
  return 1.0 / std::sqrt(1.0 + std::pow((w * w - w1 * w2) / (w * (w2 - w1)), 8));
}

TEST(BandPass, PassesWhatButterworthPasses) {
  for (const double frequency : {2.0, 5.0, 7.0, 10.0, 15.0, 30.0, 50.0, 100.0}) {
    EXPECT_NEAR(passed(frequency), expectedOf(frequency), 2e-3) << frequency;
  }
  EXPECT_NEAR(expectedOf(7.0), std::sqrt(0.5), 1e-12);
}

TEST(BandPass, ForgetsAConstant) {
  BandPass filter(4, 7.0, 30.0, kRate);
  double last = 1.0;
  for (int i = 0; i < 2048; ++i) last = filter(1e6);
  EXPECT_LT(std::abs(last), 1e-6);
}

}  // namespace
}  // namespace simgap::test
