// A pendulum that swings, logged as a quasi-direct drive does: a fine position and a coarse, noisy velocity.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "simgap/measure/logs/friction_rows.h"
#include "support/current_log.h"

namespace simgap {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr double kAmplitude = 1.4, kRate = 4.0;  // [rad], [rad/s]

double swing(double t) { return kAmplitude * std::sin(kRate * t); }
double swingSpeed(double t) { return kAmplitude * kRate * std::cos(kRate * t); }

/// 20 s at 50 Hz. \param noise  of the velocity [rad/s] \param ratio  of the shaft whose velocity it is
ActuatorLog swingLog(double noise, double ratio = 1.0) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  ActuatorLog log = test::currentLog("log.csv");
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.02 * i;
    log.time.push_back(t);
    log.position.push_back(0.003 * std::round(swing(t) / 0.003));
    log.velocity.push_back(ratio * swingSpeed(t) + noise * normal(random));
    log.effort.push_back(0.3 * std::sin(kRate * t) + 0.01 * normal(random));
  }
  log.session.assign(log.time.size(), 0), log.session_names = {"0"};
  return log;
}

FrictionData prepare(const ActuatorLog& log) {
  Bench bench;
  bench.load = BenchLoad::kFreeAxis;
  bench.inertia = {0.0, true};
  return prepareFrictionData(log, bench, {});
}

/// Of the accelerations that count [rad/s^2].
double accelerationError(const FrictionData& data) {
  double squares = 0.0;
  for (Eigen::Index i = 0; i < data.time.size(); ++i) {
    const double error = data.load_per(i, 0) + kRate * kRate * swing(data.time[i]);
    squares += error * error / static_cast<double>(data.time.size());
  }
  return std::sqrt(squares);
}

TEST(NoisyVelocity, GivesWayToAFinerPosition) {
  const FrictionData data = prepare(swingLog(0.2));
  EXPECT_THAT(data.warnings, Contains(HasSubstr("times as noisy as the slope of the position")));
  ActuatorLog without_position = swingLog(0.2);
  without_position.position.clear();
  EXPECT_LT(accelerationError(data), 0.5 * accelerationError(prepare(without_position)));
}

TEST(NoisyVelocity, StaysWhereItIsGoodOrOfAnotherShaft) {
  EXPECT_THAT(prepare(swingLog(0.02)).warnings, Not(Contains(HasSubstr("times as noisy"))));
  EXPECT_THAT(prepare(swingLog(0.4, 3.0)).warnings, Not(Contains(HasSubstr("times as noisy"))));
}

/// 78 % of a pendulum's rows were rests once: two rows within the noise, and all beside them that a smoother blurs.
TEST(NoisyVelocity, DoesNotRestWhereItPassesThroughZero) {
  ActuatorLog log = swingLog(0.2);
  log.position.clear();
  const FrictionData data = prepare(log);
  EXPECT_THAT(data.warnings, Not(Contains(HasSubstr("stands still"))));
  EXPECT_GT(data.time.size(), 450) << "rows at turns, where a smoother blurs, are left out as ever";
}

}  // namespace
}  // namespace simgap
