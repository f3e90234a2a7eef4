// Comparisons of two models piece by piece.
#include "diagnose/paired_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace simgap::test {
namespace {

GroupErrors pieces(std::size_t count, double level, std::uint64_t seed, double memory = 0.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  GroupErrors errors{Eigen::ArrayXd(static_cast<Eigen::Index>(count)), Eigen::ArrayXd::Constant(count, 100.0)};
  double state = 0.0;
  for (double& sum : errors.sum) {
    state = memory * state + std::sqrt(1.0 - memory * memory) * normal(random);
    sum = 100.0 * level * std::exp(0.3 * state);
  }
  return errors;
}

TEST(PairedError, FindsAGainAndItsSize) {
  const GroupErrors before = pieces(200, 1.0, 1);
  GroupErrors after = before;
  after.sum *= 0.9;
  const Interval gain = pairedGain(before, after, 1);
  EXPECT_NEAR(gain.value, 0.1, 1e-12);
  EXPECT_NEAR(gain.lower95, 0.1, 1e-9);  // every piece gains the same share
  EXPECT_LT(pairedP(before, after), 1e-6);
  EXPECT_GT(pairedP(after, before), 0.99);
}

TEST(PairedGain, OfIndependentErrorsHoldsTheTrueGain) {
  const Eigen::ArrayXd noise = pieces(80, 1.0, 5).sum;
  const std::vector<double> before(noise.data(), noise.data() + noise.size());
  std::vector<double> after;
  for (const double error : before) after.push_back(0.8 * error);
  const Interval gain = pairedGain(before, after, 1);
  EXPECT_NEAR(gain.value, 0.2, 1e-12);  // the same share of every one: nothing to vary
  EXPECT_NEAR(gain.lower95, 0.2, 1e-12);
  EXPECT_NEAR(gain.upper95, 0.2, 1e-12);
  std::ranges::reverse(after);
  EXPECT_LT(pairedGain(before, after, 1).lower95, 0.15);
}

TEST(PairedError, FindsWhatOnlySomePiecesShow) {
  const GroupErrors before = pieces(200, 1.0, 2);
  GroupErrors after = before;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (Eigen::Index k = 0; k < 200; ++k) after.sum[k] *= k % 8 == 0 ? 0.6 : 1.0 + 0.0005 * normal(random);
  EXPECT_LT(pairedP(before, after), 1e-4);
}

// 2000 pairs of models that differ by chance alone: few small p-values, with correlated neighbours and of few pieces.
TEST(PairedError, KeepsItsLevelUnderChance) {
  for (const auto& [count, memory] : {std::pair(120u, 0.0), std::pair(120u, 0.5), std::pair(12u, 0.0)}) {
    int at_5 = 0, at_1 = 0;
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
      const GroupErrors before = pieces(count, 1.0, 2 * seed, memory), after = pieces(count, 1.0, 2 * seed + 1, memory);
      const double p = pairedP(before, after);
      at_5 += p < 0.05 ? 1 : 0;
      at_1 += p < 0.01 ? 1 : 0;
    }
    EXPECT_LE(at_5, 130) << count << ' ' << memory;  // 100 expected; three standard deviations of a binomial are 29
    EXPECT_LE(at_1, 34) << count << ' ' << memory;   // 20 and 13
  }
}

/// Of a model with one column more, fitted elsewhere: sums of squares of both, and of products, on `count` pieces of
/// 100 rows. \param truth, fitted  of the column, in noises of a row
struct NestedModelsOf {
  GroupErrors before, after;
  Nested added;

  NestedModelsOf(Eigen::Index count, double truth, double fitted, std::uint64_t seed)
      : added{Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count)} {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    before = after = {Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Constant(count, 100.0)};
    for (Eigen::Index row = 0; row < 100 * count; ++row) {
      const double column = normal(random), error = truth * column + normal(random), left = error - fitted * column;
      before.sum[row / 100] += error * error;
      after.sum[row / 100] += left * left;
      added.products[row / 100] += error * (error - left);
      added.squares[row / 100] += (error - left) * (error - left);
    }
  }
};

// 30 pieces of 100 rows, 0.15 % of the squared error: twice the standard deviations of what squared errors show.
TEST(NestedModels, ShowWhatSquaredErrorsHide) {
  int squared = 0, nested = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const NestedModelsOf models(30, 0.04, 0.04, seed);
    squared += pairedP(models.before, models.after) < 0.05 ? 1 : 0;
    nested += nestedP(models.added) < 0.05 ? 1 : 0;
  }
  EXPECT_LT(squared, 160);
  EXPECT_GT(nested, 260);
}

TEST(NestedModels, KeepTheirLevelWhereTheColumnIsNone) {
  int at_5 = 0, at_1 = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const double p = nestedP(NestedModelsOf(12, 0.0, 0.03, seed).added);
    at_5 += p < 0.05 ? 1 : 0;
    at_1 += p < 0.01 ? 1 : 0;
  }
  EXPECT_LE(at_5, 130);  // as above
  EXPECT_LE(at_1, 34);
}

TEST(PairedError, IntervalsCoverTheTrueGain) {
  int covered = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const GroupErrors before = pieces(150, 1.0, 10 + seed);
    GroupErrors after = before;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.92, 0.1);
    for (double& sum : after.sum) sum *= normal(random);
    const Interval gain = pairedGain(before, after, seed);
    covered += gain.lower95 <= 0.08 && 0.08 <= gain.upper95 ? 1 : 0;
  }
  EXPECT_GE(covered, 270);
}

struct Pair {
  GroupErrors before, after;
  double gain() const { return 1.0 - after.sum.sum() / before.sum.sum(); }
};

/// Sessions of uneven length, of which some show much more of a cause than others do.
Pair drawSessions(Eigen::Index sessions, double share, double spread, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(500.0, 2000.0);
  Pair pair{{Eigen::ArrayXd(sessions), Eigen::ArrayXd(sessions)}, {Eigen::ArrayXd(sessions), Eigen::ArrayXd(sessions)}};
  for (Eigen::Index s = 0; s < sessions; ++s) {
    const double rows = uniform(random);
    const double explained = share * std::exp(spread * normal(random) - 0.5 * spread * spread);
    pair.before.rows[s] = pair.after.rows[s] = rows;
    pair.after.sum[s] = rows * (1.0 + normal(random) * std::sqrt(2.0 / rows));
    pair.before.sum[s] = pair.after.sum[s] + rows * explained;
  }
  return pair;
}

TEST(PredictedGain, CoversTheGainOnAnotherLog) {
  std::mt19937_64 random(3);
  for (const double spread : {0.3, 1.0}) {
    for (const double share : {0.06, 0.5}) {
      constexpr int kLogs = 200;
      int inside = 0, narrow_inside = 0;
      for (int log = 0; log < kLogs; ++log) {
        const Pair measured = drawSessions(20, share, spread, random),
                   another = drawSessions(20, share, spread, random);
        const Interval gain = predictedGain(measured.before.sum, measured.after.sum, 1);
        EXPECT_NEAR(gain.value, measured.gain(), 1e-12);
        inside += gain.lower95 <= another.gain() && another.gain() <= gain.upper95 ? 1 : 0;
        const Interval of_mean = pairedGain(measured.before, measured.after, 1);
        narrow_inside += of_mean.lower95 <= another.gain() && another.gain() <= of_mean.upper95 ? 1 : 0;
      }
      EXPECT_GE(inside, 0.90 * kLogs) << spread << " " << share;
      EXPECT_LT(inside, 0.995 * kLogs) << "no interval is worth its name that never misses";
      EXPECT_LT(narrow_inside, inside) << "a mean is known better than the next value";
    }
  }
}

TEST(PredictedGain, OfNothingLiesOnBothSidesOfZero) {
  std::mt19937_64 random(4);
  Pair pair = drawSessions(20, 0.0, 0.3, random);
  pair.after.sum *= 1.0 + 1e-3;  // and a little worse
  const Interval gain = predictedGain(pair.before.sum, pair.after.sum, 1);
  EXPECT_LE(gain.value, 0.0);
  EXPECT_LE(gain.lower95, gain.value);
  EXPECT_GE(gain.upper95, gain.value);
}

TEST(Diagnosis, DoubtsACauseThatMakesOtherDataWorse) {
  Diagnosis diagnosis;
  diagnosis.causes.resize(2);
  diagnosis.causes[0].gain_heldout = {0.2, 0.1, 0.3};
  diagnosis.causes[1].effect = "channel-delay";
  diagnosis.causes[1].gain_heldout = {-0.5, -0.9, 0.0};
  warnOfHarm(diagnosis);
  ASSERT_EQ(diagnosis.warnings.size(), 1u);
  EXPECT_TRUE(diagnosis.warnings[0].starts_with("channel-delay makes the data it was not chosen on worse, by 50 %"));
}

}  // namespace
}  // namespace simgap::test
