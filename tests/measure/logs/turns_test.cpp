// Where a joint turns back, and how far it travels until its friction has built up.
#include "measure/logs/turns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace simgap {
namespace {

/// 60 s at 200 Hz of two sines; friction 1 N m beside a load that is slower.
struct TurningLog {
  std::vector<double> time, position, velocity, effort;
  std::vector<Block> runs;
  MotionSign sign;

  double travel() const {
    return travelOfFriction({time, position, effort}, turnsOf(sign.direction, runs), runs, sign, 0.2);
  }
};

/// \param builds_up  [rad] x_s of Dahl's friction, dz/dx = (1 - z sgn v) / x_s; 0: kinetic at once
/// \param noise  [N m]
TurningLog recordTurns(double builds_up, double noise = 0.02) {
  constexpr int kRows = 12000, kSteps = 20;
  constexpr double kStep = 0.005;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  TurningLog log;
  double z = 0.0;
  const auto positionAt = [](double t) { return 0.8 * std::sin(1.1 * t) + 0.3 * std::sin(2.9 * t + 0.5); };
  for (int i = 0; i < kRows; ++i) {
    const double t = kStep * i, v = 0.88 * std::cos(1.1 * t) + 0.87 * std::cos(2.9 * t + 0.5);
    log.time.push_back(t);
    log.position.push_back(positionAt(t));
    log.velocity.push_back(v);
    const double friction = builds_up > 0.0 ? z : std::copysign(1.0, v);
    log.effort.push_back(friction + 3.0 * std::sin(positionAt(t)) + noise * normal(random));
    for (int k = 0; k < kSteps; ++k) {
      const double dx = positionAt(t + kStep * (k + 1) / kSteps) - positionAt(t + kStep * k / kSteps);
      if (builds_up > 0.0)
        z = std::copysign(1.0, dx) + (z - std::copysign(1.0, dx)) * std::exp(-std::abs(dx) / builds_up);
    }
  }
  log.runs = {{0, log.time.size()}};
  log.sign = holdSign(log.velocity);
  return log;
}

TEST(Turns, TravelIsThatOfDahl) {
  for (const double builds_up : {5e-4, 2e-3}) {
    EXPECT_NEAR(recordTurns(builds_up).travel(), 4.6 * builds_up, 1.4 * builds_up);
  }
}

TEST(Turns, KineticFrictionNeedsNoTravel) { EXPECT_LT(recordTurns(0.0).travel(), 1e-4); }

// Taken for friction that is there at once it passed for a late effort.
TEST(Turns, NoiseThatHidesTheTravelDoesNotSayThatThereIsNone) {
  EXPECT_GE(recordTurns(2e-3, 3.0).travel(), kUntold);
  EXPECT_GE(recordTurns(0.0, 3.0).travel(), kUntold);
}

// Six turns are the fewest that tell.
TEST(Turns, FewDoNotSayThatThereIsNoTravel) {
  TurningLog log = recordTurns(0.0);
  const std::vector<std::size_t> turns = turnsOf(log.sign.direction, log.runs);
  log.runs = {{0, turns[4]}};
  EXPECT_EQ(log.travel(), kUntold);
  log.runs = {{turns[4], turns[5]}};
  EXPECT_EQ(log.travel(), 0.0) << "where nothing turns, turns do no harm";
}

TEST(Turns, BlurredRowsBesideThemAreLeftOut) {
  TurningLog log = recordTurns(0.0);
  const std::vector<std::size_t> turns = turnsOf(log.sign.direction, log.runs);
  ASSERT_GT(turns.size(), 20u);
  leaveOutTurns(log.time, log.runs, 0.025, log.sign);
  for (const std::size_t turn : turns) {
    for (int k = -4; k <= 4; ++k) {  // 25 ms on either side
      const std::size_t row = std::min(turn + k, log.time.size() - 1);
      if (row == turn + k) {
        EXPECT_FALSE(log.sign.keep[row]) << turn << " " << k;
      }
    }
  }
  EXPECT_TRUE(log.sign.keep[turns[3] + 8]);
  EXPECT_FALSE(log.sign.keep[4]);  // nor does a smoother know what was before the first row
  EXPECT_FALSE(log.sign.keep[log.time.size() - 5]);
}

TEST(Turns, HalfOfTheRowsStay) {
  TurningLog log = recordTurns(0.0);
  const auto before = std::ranges::count(log.sign.keep, true);
  leaveOutTurns(log.time, log.runs, 0.5, log.sign);
  EXPECT_GE(2 * std::ranges::count(log.sign.keep, true), before);
  const auto left = std::ranges::count(log.sign.keep, true);
  leaveOutFirstTravel(log.position, log.velocity, log.runs, 1e-3, 10.0, log.sign);
  EXPECT_GE(2 * std::ranges::count(log.sign.keep, true), left);
}

TEST(Turns, TheFirstTravelIsLeftOutAfterRestsToo) {
  std::vector<double> position, velocity;
  for (int i = 0; i < 300; ++i) {  // a rest from row 100 to 199
    velocity.push_back(i < 100 || i >= 200 ? 1.0 : 0.0);
    position.push_back((position.empty() ? 0.0 : position.back()) + 0.01 * velocity.back());
  }
  const std::vector<Block> runs = {{0, 300}};
  MotionSign sign;
  sign.direction.assign(300, 1);
  sign.keep.assign(300, true);
  leaveOutFirstTravel(position, velocity, runs, 1e-3, 0.2, sign);
  EXPECT_FALSE(sign.keep[10]);
  EXPECT_TRUE(sign.keep[30]);
  EXPECT_FALSE(sign.keep[210]);
  EXPECT_TRUE(sign.keep[230]);
}

}  // namespace
}  // namespace simgap
