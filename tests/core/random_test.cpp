#include "simgap/core/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Words = std::array<std::uint64_t, 2>;

// The known answer that the authors of Threefry-2x64-20 publish for key 0 and counter 0.
TEST(CounterRandom, GivesThePublishedAnswer) {
  EXPECT_EQ(CounterRandom(0).bits({}), (Words{0xc2b6e3a8c2c69865U, 0x6f81ed42f350084dU}));
}

// Pinned so that a run stored by one version resumes with the same numbers in every later one. Do not "repair" them.
TEST(CounterRandom, StreamIsPinned) {
  const CounterRandom random(20261120);
  EXPECT_EQ(random.bits({1, 2, 3, 4}), (Words{0x747fe24c952c92d7U, 0xeacbda15912039b0U}));
  EXPECT_EQ(random.bits({249, 35, 98, 2}), (Words{0x83d6fa149bd675d5U, 0x7be5acf1b0861309U}));
  EXPECT_EQ(random.uniform({1, 2, 3, 4}), 0x1.d1ff893254b26p-2);
  // sin, cos and log of the C library may differ in the last bit between its versions.
  const auto [a, b] = random.normalPair({1, 2, 3, 4});
  EXPECT_NEAR(a, 1.0886990395660885, 1e-15);
  EXPECT_NEAR(b, -0.62395073880133856, 1e-15);
}

TEST(CounterRandom, SeedAndEveryFieldMatter) {
  std::set<Words> seen;
  std::size_t draws = 0;
  const auto draw = [&](std::uint64_t seed, const RandomCounter& counter) {
    seen.insert(CounterRandom(seed).bits(counter));
    ++draws;
  };
  draw(7, {});
  for (int bit = 0; bit < 64; ++bit) draw(7 ^ (std::uint64_t{1} << bit), {});
  for (int bit = 0; bit < 32; ++bit) {
    const std::uint32_t flipped = std::uint32_t{1} << bit;
    draw(7, {flipped, 0, 0, 0});
    draw(7, {0, flipped, 0, 0});
    draw(7, {0, 0, flipped, 0});
    draw(7, {0, 0, 0, flipped});
  }
  EXPECT_EQ(seen.size(), draws);
}

TEST(CounterRandom, EqualCountersGiveEqualNumbers) {
  const CounterRandom a(5), b(5);
  EXPECT_EQ(a.bits({1, 2, 3, 4}), b.bits({1, 2, 3, 4}));
  EXPECT_EQ(a.normalPair({1, 2, 3, 4}), b.normalPair({1, 2, 3, 4}));
}

TEST(CounterRandom, UniformIsOpenAndFlat) {
  constexpr std::uint32_t kDraws = 200000;
  constexpr std::size_t kCells = 20;
  const CounterRandom random(3);
  std::vector<int> counts(kCells);
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const double u = random.uniform({i, 0, 0, 0});
    ASSERT_GT(u, 0.0);
    ASSERT_LT(u, 1.0);
    ++counts[static_cast<std::size_t>(u * kCells)];
  }
  const double expected = static_cast<double>(kDraws) / kCells;
  double chi_square = 0.0;
  for (const int count : counts) chi_square += (count - expected) * (count - expected) / expected;
  EXPECT_LT(chi_square, 43.8);  // 99.9 % quantile for 19 degrees of freedom
}

// Bounds are 4 standard errors: var(mean) = 1/n, var(z^2) = 2, var(z^3) = 15, var(z^4) = 96.
TEST(CounterRandom, NormalsHaveTheMomentsOfTheNormalDistribution) {
  constexpr std::uint32_t kPairs = 250000;
  const CounterRandom random(11);
  double m1 = 0.0, m2 = 0.0, m3 = 0.0, m4 = 0.0;
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    for (const double z : random.normalPair({0, i, 0, 0})) {
      ASSERT_TRUE(std::isfinite(z));
      m1 += z, m2 += z * z, m3 += z * z * z, m4 += z * z * z * z;
    }
  }
  const double n = 2.0 * kPairs;
  EXPECT_NEAR(m1 / n, 0.0, 4.0 * std::sqrt(1.0 / n));
  EXPECT_NEAR(m2 / n, 1.0, 4.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(m3 / n, 0.0, 4.0 * std::sqrt(15.0 / n));
  EXPECT_NEAR(m4 / n, 3.0, 4.0 * std::sqrt(96.0 / n));
}

// A correlation of n independent pairs has the standard error 1/sqrt(n).
TEST(CounterRandom, NeighboursAreIndependent) {
  constexpr std::uint32_t kDraws = 100000;
  const double bound = 4.0 / std::sqrt(static_cast<double>(kDraws));
  const CounterRandom random(1), next_seed(2);
  std::vector<double> here, twin, generation, individual, parameter, purpose, seed;
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const RandomCounter place{i, i / 7, i / 3, i / 5};
    const auto [first, second] = random.normalPair(place);
    here.push_back(first);
    twin.push_back(second);
    const auto at = [&](std::uint32_t g, std::uint32_t k, std::uint32_t j, std::uint32_t p) {
      return random.normalPair({place.generation + g, place.individual + k, place.parameter + j, place.purpose + p})[0];
    };
    generation.push_back(at(1, 0, 0, 0));
    individual.push_back(at(0, 1, 0, 0));
    parameter.push_back(at(0, 0, 1, 0));
    purpose.push_back(at(0, 0, 0, 1));
    seed.push_back(next_seed.normalPair(place)[0]);
  }
  EXPECT_NEAR(correlation(here, twin), 0.0, bound);
  EXPECT_NEAR(correlation(here, generation), 0.0, bound);
  EXPECT_NEAR(correlation(here, individual), 0.0, bound);
  EXPECT_NEAR(correlation(here, parameter), 0.0, bound);
  EXPECT_NEAR(correlation(here, purpose), 0.0, bound);
  EXPECT_NEAR(correlation(here, seed), 0.0, bound);
}

}  // namespace
}  // namespace simgap
