#include "simgap/measure/logs/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace simgap {
namespace {

std::vector<double> times(std::size_t n, double rate) {
  std::vector<double> t(n);
  for (std::size_t i = 0; i < n; ++i) t[i] = static_cast<double>(i) / rate;
  return t;
}

TEST(HoldSign, KeepsTheDirectionThroughARestAndTurnsAtTheTurningPoint) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  std::vector<double> v, truth;
  for (int i = 0; i < 2000; ++i) {
    // Forth for 5 s, rest for 10 s, back for 5 s, at 100 Hz.
    const double w = i < 500    ? 5.0 * std::sin(std::numbers::pi * i / 500.0)
                     : i < 1500 ? 0.0
                                : -5.0 * std::sin(std::numbers::pi * (i - 1500) / 500.0);
    v.push_back(w + 0.1 * normal(random));
    truth.push_back(i < 1500 ? 1.0 : -1.0);
  }
  const MotionSign sign = holdSign(v);
  EXPECT_EQ(sign.reversals, 1u);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < v.size(); ++i) wrong += sign.keep[i] && sign.direction[i] != truth[i];
  EXPECT_LE(wrong, 6u) << "the turn may be some samples off, where the velocity is within its noise";
}

TEST(HoldSign, LeavesOutWhatComesBeforeTheFirstMotion) {
  const MotionSign sign = holdSign(std::vector<double>{0.0, 0.0, 1.0, 1.0, -1.0, -1.0}, 3.5, 0.5);
  EXPECT_EQ(sign.keep, (std::vector<bool>{false, false, true, false, false, true}));
  EXPECT_EQ(sign.direction[3], 1);
  EXPECT_EQ(sign.direction[4], -1);
}

TEST(RawSign, IsTheSign) {
  const MotionSign sign = rawSign(std::vector<double>{-2.0, 0.0, 3.0});
  EXPECT_EQ(sign.direction, (std::vector<signed char>{-1, 0, 1}));
  EXPECT_EQ(sign.keep, (std::vector<bool>{true, true, true}));
}

TEST(Smooth, HalvesASineAtItsBandwidthWithoutShiftingIt) {
  for (const double rate : {200.0, 1000.0}) {
    const std::vector<double> t = times(4000, rate);
    std::vector<double> y;
    for (const double s : t) y.push_back(std::sin(2.0 * std::numbers::pi * 5.0 * s));
    const std::vector<double> smoothed = smooth(t, y, 5.0);
    for (std::size_t i = 1000; i < 3000; ++i) EXPECT_NEAR(smoothed[i], 0.5 * y[i], 2e-3);
  }
}

TEST(SplitRuns, AtSessionsAndGapsButNotInBursts) {
  std::vector<double> time;
  for (int i = 0; i < 100; ++i) time.push_back(0.01 * i + (i >= 40 ? 0.2 : 0.0));
  for (int i = 0; i < 50; ++i) time.push_back(0.01 * i);
  std::vector<int> session(time.size(), 0);
  std::fill(session.begin() + 100, session.end(), 1);
  const std::vector<Block> runs = splitRuns(time, session);
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[1].begin, 40u);
  EXPECT_EQ(runs[2].begin, 100u);
  EXPECT_NEAR(samplingRate(time, runs), 100.0, 1e-9);
  // Four rows at once, every 40 ms.
  std::vector<double> bursts;
  for (int i = 0; i < 100; ++i) bursts.push_back(0.04 * (i / 4) + 1e-5 * (i % 4));
  EXPECT_EQ(splitRuns(bursts, std::vector<int>(bursts.size(), 0)).size(), 1u);
}

TEST(Smooth, BurstsOfStampsAreNoSpeed) {
  // Read every 1 ms, handed over four at a time with a stamp each: the stamps lie 50 us apart, then 3.85 ms.
  std::vector<double> t, y, truth;
  for (int i = 0; i < 4000; ++i) {
    t.push_back(0.004 * (i / 4) + 5e-5 * (i % 4));
    y.push_back(std::sin(4.0 * t.back()));
    truth.push_back(4.0 * std::cos(4.0 * t.back()));
  }
  const std::vector<double> speed = differentiate(t, smooth(t, y, 20.0));
  double worst = 0.0;
  for (std::size_t i = 100; i + 100 < t.size(); ++i) worst = std::max(worst, std::abs(speed[i] - truth[i]));
  EXPECT_LT(worst, 0.1);  // of a top speed of 4
}

// At 100 rows a second a secant of neighbours is 3 % short of a servo that rings at 7 Hz, and its inertia as much too
// large.
TEST(Differentiate, FollowsWhatRingsAlsoOnStampsThatJitter) {
  constexpr double w = 2.0 * 3.14159265358979 * 7.0;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> late(-0.001, 0.001);
  std::vector<double> t, y;
  for (int i = 0; i < 500; ++i) {
    t.push_back(0.01 * i + late(random));
    y.push_back(std::sin(w * t.back()));
  }
  const std::vector<double> slope = differentiate(t, y);
  for (std::size_t i = 2; i + 2 < t.size(); ++i) EXPECT_NEAR(slope[i], w * std::cos(w * t[i]), 0.005 * w) << i;
}

TEST(Smooth, LeavesParabolasAloneAlsoOnUnevenTimes) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  std::vector<double> t{0.0}, y{1.0};
  while (t.size() < 500) {
    t.push_back(t.back() + 0.01 * uniform(random));
    y.push_back(1.0 + 2.0 * t.back() - 3.0 * t.back() * t.back());
  }
  const std::vector<double> smoothed = smooth(t, y, 3.0);
  const std::vector<double> slope = differentiate(t, smoothed);
  for (std::size_t i = 1; i + 1 < t.size(); ++i) {
    EXPECT_NEAR(smoothed[i], y[i], 1e-6);
    EXPECT_NEAR(slope[i], 2.0 - 6.0 * t[i], 1e-4);
  }
}

}  // namespace
}  // namespace simgap
