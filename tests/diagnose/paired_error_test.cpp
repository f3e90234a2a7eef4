// Comparisons of two models piece by piece.
#include "../../src/diagnose/paired_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace simgap::test {
namespace {

PieceErrors pieces(std::size_t count, double level, std::uint64_t seed, double memory = 0.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  PieceErrors errors{Eigen::ArrayXd(static_cast<Eigen::Index>(count)),
                     Eigen::ArrayXd::Constant(static_cast<Eigen::Index>(count), 100.0)};
  double state = 0.0;
  for (double& sum : errors.sum) {
    state = memory * state + std::sqrt(1.0 - memory * memory) * normal(random);
    sum = 100.0 * level * std::exp(0.3 * state);
  }
  return errors;
}

TEST(PairedError, FindsAGainAndItsSize) {
  const PieceErrors before = pieces(200, 1.0, 1);
  PieceErrors after = before;
  after.sum *= 0.9;
  const Interval gain = pairedGain(before, after, 1);
  EXPECT_NEAR(gain.value, 0.1, 1e-12);
  EXPECT_NEAR(gain.lower95, 0.1, 1e-9);  // every piece gains the same share
  EXPECT_LT(pairedP(before, after), 1e-6);
  EXPECT_GT(pairedP(after, before), 0.99);
}

TEST(PairedError, FindsWhatOnlySomePiecesShow) {
  const PieceErrors before = pieces(200, 1.0, 2);
  PieceErrors after = before;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (Eigen::Index k = 0; k < 200; ++k) after.sum[k] *= k % 8 == 0 ? 0.6 : 1.0 + 0.0005 * normal(random);
  EXPECT_LT(pairedP(before, after), 1e-4);
}

// 1000 pairs of models that differ by chance alone: few small p-values, also with correlated neighbours.
TEST(PairedError, KeepsItsLevelUnderChance) {
  for (const double memory : {0.0, 0.5}) {
    int alarms = 0;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
      const PieceErrors before = pieces(120, 1.0, 2 * seed, memory), after = pieces(120, 1.0, 2 * seed + 1, memory);
      alarms += pairedP(before, after) < 0.05 ? 1 : 0;
    }
    EXPECT_LE(alarms, 65) << memory;  // 50 expected at most; 2 standard deviations of a binomial are 14
  }
}

TEST(PairedError, IntervalsCoverTheTrueGain) {
  int covered = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const PieceErrors before = pieces(150, 1.0, 10 + seed);
    PieceErrors after = before;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.92, 0.1);
    for (double& sum : after.sum) sum *= normal(random);
    const Interval gain = pairedGain(before, after, seed);
    covered += gain.lower95 <= 0.08 && 0.08 <= gain.upper95 ? 1 : 0;
  }
  EXPECT_GE(covered, 270);
}

}  // namespace
}  // namespace simgap::test
