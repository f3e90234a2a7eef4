// When a drive stands still: not in a reversal, but also while it creeps.
#include "simgap/measure/logs/rests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

struct RestingMotion {
  std::vector<double> time, velocity;
  std::vector<int> session;
  void add(double seconds, double speed) {
    for (int i = 0; i < static_cast<int>(50.0 * seconds); ++i) {
      time.push_back(0.02 * static_cast<double>(time.size()));
      velocity.push_back(speed);
      session.push_back(0);
    }
  }
  std::ptrdiff_t resting(double slow) const {
    return std::ranges::count(findRests(time, velocity, session, {slow}), true);
  }
};

TEST(Rests, ALongStandstillThatCreeps) {
  RestingMotion m;
  m.add(2.0, 10.0);
  m.add(6.0, 0.01);
  m.add(2.0, -10.0);
  EXPECT_EQ(m.resting(0.02), 300);
}

TEST(Rests, AReversalPassesThrough) {
  RestingMotion m;
  m.add(2.0, 10.0);
  m.add(0.1, 0.0);
  m.add(2.0, -10.0);
  EXPECT_EQ(m.resting(0.02), 0);
}

TEST(Rests, EndWithTheirSession) {
  RestingMotion m;
  m.add(0.2, 0.0);
  m.add(0.2, 0.0);
  EXPECT_EQ(m.resting(0.02), 20);
  std::fill(m.session.begin() + 10, m.session.end(), 1);
  EXPECT_EQ(m.resting(0.02), 0);
}

TEST(Rests, ASmoothedVelocityBlursTheirEnds) {
  RestingMotion m;
  m.add(2.0, 10.0);
  m.add(0.2, 0.0);
  m.add(2.0, -10.0);
  const auto rests = [&](const RestRule& rule) {
    return std::ranges::count(findRests(m.time, m.velocity, m.session, rule), true);
  };
  EXPECT_EQ(rests({.slow = 0.02, .least_seconds = 0.1}), 10);
  EXPECT_EQ(rests({.slow = 0.02, .least_seconds = 0.1, .fewest_rows = 4, .blurred_seconds = 0.07}),
            16);  // three rows at either end
}

TEST(Rests, CreepIsSlowAgainstTheUsualMotion) {
  std::vector<double> velocity(1000, 5.0);
  EXPECT_DOUBLE_EQ(restingSpeed(velocity, 0.001), 0.01);
  EXPECT_DOUBLE_EQ(restingSpeed(velocity, 0.5), 0.5);
}

}  // namespace
}  // namespace simgap
