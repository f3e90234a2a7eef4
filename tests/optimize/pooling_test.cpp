#include "simgap/optimize/pooling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace simgap {
namespace {

constexpr int kSets = 2000;

/// Groups that scatter by tau, each measured with its own sd between 0.5 and 2; `step` from group `first` on.
std::vector<GroupEstimate> drawn(std::mt19937_64& random, std::size_t count, double tau, double step = 0.0,
                                 std::size_t first = 0) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> spread(0.5, 2.0);
  std::vector<GroupEstimate> groups;
  for (std::size_t i = 0; i < count; ++i) {
    const double sd = spread(random);
    groups.push_back({10.0 + tau * normal(random) + (i >= first ? step : 0.0) + sd * normal(random), sd});
  }
  return groups;
}

// Worked by hand: weights 1 and 1/4, so mu = (1 + 4/4) / (5/4) = 1.6, Q = 0.6^2 + 2.4^2 / 4 = 1.8 > k - 1 = 1.
TEST(Pool, TwoGroupsByHand) {
  const std::vector<GroupEstimate> groups{{1.0, 1.0}, {4.0, 2.0}};
  const PooledEstimate pooled = pool(groups);
  // Q(v) = 9 / (5 + 2 v) for two groups: the difference squared over its variance.
  EXPECT_NEAR(pooled.scatter * pooled.scatter, 2.0, 1e-9);
  EXPECT_NEAR(pooled.p_equal, std::erfc(std::sqrt(1.8 / 2.0)), 1e-12);
  EXPECT_NEAR(pooled.mean, (1.0 / 3.0 + 4.0 / 6.0) / (1.0 / 3.0 + 1.0 / 6.0), 1e-9);
  EXPECT_NEAR(pooled.groups[0].value, pooled.mean + 2.0 / 3.0 * (1.0 - pooled.mean), 1e-9);
  EXPECT_EQ(pooled.scatter_lower, 0.0);
}

TEST(Pool, EqualGroupsAreDrawnTogether) {
  const std::vector<GroupEstimate> groups{{2.0, 0.1}, {2.0, 0.1}, {2.0, 0.1}};
  const PooledEstimate pooled = pool(groups);
  EXPECT_EQ(pooled.scatter, 0.0);
  EXPECT_EQ(pooled.p_equal, 1.0);
  for (const GroupEstimate& group : pooled.groups) EXPECT_DOUBLE_EQ(group.value, 2.0);
}

// 2000 sets: a rate of 0.05 has a standard deviation of 0.005, one of 0.95 as well; four of them are allowed.
TEST(Pool, ItsTestAndIntervalsHoldAsOftenAsTheySay) {
  std::mt19937_64 random(1);
  int false_alarms = 0, mean_held = 0, scatter_held = 0;
  for (int s = 0; s < kSets; ++s) {
    false_alarms += pool(drawn(random, 6, 0.0)).p_equal < 0.05;
    const PooledEstimate pooled = pool(drawn(random, 6, 1.5));
    mean_held += pooled.mean_lower < 10.0 && 10.0 < pooled.mean_upper;
    scatter_held += pooled.scatter_lower < 1.5 && 1.5 < pooled.scatter_upper;
  }
  EXPECT_NEAR(false_alarms, 0.05 * kSets, 0.02 * kSets);
  EXPECT_GT(mean_held, 0.93 * kSets);
  EXPECT_NEAR(scatter_held, 0.95 * kSets, 0.02 * kSets);
}

TEST(FindChange, NeedsFourGroups) {
  std::mt19937_64 random(2);
  EXPECT_FALSE(findChange(drawn(random, 3, 0.0)));
  EXPECT_TRUE(findChange(drawn(random, 4, 0.0)));
}

TEST(FindChange, ScatterAloneIsNoChange) {
  std::mt19937_64 random(3);
  for (const double tau : {0.0, 2.0}) {
    int found = 0;
    for (int s = 0; s < kSets; ++s) found += findChange(drawn(random, 8, tau))->p < 0.05;
    EXPECT_LE(found, 0.06 * kSets) << "tau " << tau;  // at most 0.05, and two standard deviations
  }
}

// Runs whose standard deviations differ by orders of magnitude: a few that are well known stand for no row of runs.
TEST(FindChange, AFewGroupsThatAreWellKnownAreNoChange) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  int found = 0;
  for (int s = 0; s < kSets; ++s) {
    std::vector<GroupEstimate> groups;
    for (int i = 0; i < 6; ++i) {
      const double sd = std::exp(1.5 * normal(random));
      const double scatter = normal(random);
      const double noise = sd * normal(random);
      groups.push_back({10.0 + scatter + noise, sd});
    }
    found += findChange(groups)->p < 0.05;
  }
  EXPECT_LE(found, 0.06 * kSets);  // 0.12 with k - 2 freedoms
}

TEST(FindChange, ADriftIsNoChangeAtOneTime) {
  std::mt19937_64 random(6);
  int found = 0;
  for (int s = 0; s < kSets; ++s) {
    std::vector<GroupEstimate> groups = drawn(random, 8, 0.0);
    for (std::size_t i = 0; i < groups.size(); ++i) groups[i].value += 2.0 * static_cast<double>(i);
    found += findChange(groups)->p < 0.05;
  }
  EXPECT_LE(found, 0.06 * kSets);  // 0.72 where a step has no rival
}

TEST(FindChange, SaysSinceWhenAndByHowMuch) {
  std::mt19937_64 random(4);
  int found = 0, place_held = 0, size_held = 0;
  for (int s = 0; s < kSets; ++s) {
    const ChangePoint change = *findChange(drawn(random, 10, 0.3, 8.0, 6));
    found += change.p < 0.05;
    place_held += change.earliest <= 6 && 6 <= change.latest;
    size_held += std::abs(change.step.value - 8.0) < 2.31 * change.step.sd;  // Student's t, 8 freedoms
  }
  EXPECT_GT(found, 0.95 * kSets);
  EXPECT_GT(place_held, 0.93 * kSets);
  EXPECT_GT(size_held, 0.93 * kSets);
}

TEST(FindDrift, ScatterAloneIsNoDrift) {
  std::mt19937_64 random(7);
  for (const double tau : {0.0, 2.0}) {
    int found = 0;
    for (int s = 0; s < kSets; ++s) found += findDrift(drawn(random, 8, tau))->p < 0.05;
    EXPECT_LE(found, 0.06 * kSets) << "tau " << tau;
  }
}

TEST(FindDrift, AStepIsNoDrift) {
  std::mt19937_64 random(8);
  int found = 0;
  for (int s = 0; s < kSets; ++s) found += findDrift(drawn(random, 8, 0.0, 8.0, 4))->p < 0.05;
  EXPECT_LE(found, 0.06 * kSets);
}

TEST(FindDrift, SaysByHowMuchFromGroupToGroup) {
  std::mt19937_64 random(9);
  int found = 0, held = 0;
  for (int s = 0; s < kSets; ++s) {
    std::vector<GroupEstimate> groups = drawn(random, 8, 0.3);
    for (std::size_t i = 0; i < groups.size(); ++i) groups[i].value += 2.0 * static_cast<double>(i);
    const Drift drift = *findDrift(groups);
    found += drift.p < 0.05;
    held += std::abs(drift.slope.value - 2.0) < 2.45 * drift.slope.sd;  // Student's t, 6 freedoms
  }
  EXPECT_GT(found, 0.8 * kSets);
  EXPECT_GT(held, 0.93 * kSets);
}

// S. Holm, "A simple sequentially rejective multiple test procedure", Scandinavian Journal of Statistics 6, 1979.
TEST(HolmAdjusted, MultipliesByWhatIsLeftAndNeverFalls) {
  const std::vector<double> p{0.04, 0.01, 0.03, 0.5};
  const std::vector<double> adjusted = holmAdjusted(p);
  EXPECT_DOUBLE_EQ(adjusted[1], 0.04);
  EXPECT_DOUBLE_EQ(adjusted[2], 0.09);
  EXPECT_DOUBLE_EQ(adjusted[0], 0.09);
  EXPECT_DOUBLE_EQ(adjusted[3], 0.5);
}

}  // namespace
}  // namespace simgap
