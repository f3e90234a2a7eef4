// A velocity that is late against the position beside it.
#include "simgap/measure/logs/velocity_lag.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "simgap/measure/logs/motion.h"

namespace simgap {
namespace {

struct MotionLog {
  std::vector<double> time, position, velocity;
  std::vector<int> session;

  std::optional<double> lag() const { return velocityLag(time, position, velocity, splitRuns(time, session)); }
};

double speedAt(double t) { return 2.0 * std::cos(1.3 * t) + 1.5 * std::cos(4.1 * t + 0.4); }

/// Two sessions of 15 s at 100 Hz. \param late  [s] \param noise  of the velocity.
MotionLog recordMotion(double late, double noise) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  MotionLog log;
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.01 * i;
    log.time.push_back(t);
    const double angle = 2.0 / 1.3 * std::sin(1.3 * t) + 1.5 / 4.1 * std::sin(4.1 * t + 0.4);
    log.position.push_back(std::round(angle / 1.5e-3) * 1.5e-3);
    log.velocity.push_back(speedAt(t - late) + noise * normal(random));
    log.session.push_back(i / 1500);
  }
  return log;
}

TEST(VelocityLag, IsTheTimeByWhichItIsLate) {
  for (const double late : {0.02, 0.037, -0.02}) {
    const auto lag = recordMotion(late, 0.05).lag();
    ASSERT_TRUE(lag) << late;
    EXPECT_NEAR(*lag, late, 0.001);
  }
}

/// Beside bristles 4.5 ms at 100 Hz passed for an inertia.
TEST(VelocityLag, IsFoundWhereItIsLessThanHalfARow) {
  const auto lag = recordMotion(0.0045, 0.01).lag();
  ASSERT_TRUE(lag);
  EXPECT_NEAR(*lag, 0.0045, 0.0005);
}

TEST(VelocityLag, IsAFiltersTimeConstant) {
  MotionLog log = recordMotion(0.0, 0.0);
  double filtered = log.velocity[0];
  for (double& v : log.velocity) v = filtered += (v - filtered) * 0.01 / 0.03;
  const auto lag = log.lag();
  ASSERT_TRUE(lag);
  EXPECT_NEAR(*lag, 0.02, 0.006);  // of the filter as sampled: 30 ms less a row
}

/// Four seconds each: a second of even speed between ramps of a tenth, and a rest of the other half and more. The
/// median speed is 0, and at an even speed none is late.
MotionLog recordTrapezoids(double late) {
  const auto trapezoid = [](double t) {
    const double phase = std::fmod(std::max(t, 0.0), 4.0);
    return 2.0 * std::clamp(std::min(phase, 1.2 - phase) / 0.1, 0.0, 1.0);
  };
  MotionLog log;
  double angle = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.01 * i, side = std::fmod(t, 8.0) < 4.0 ? 1.0 : -1.0;
    log.time.push_back(t);
    log.position.push_back(std::round(angle / 1e-4) * 1e-4);
    log.velocity.push_back((std::fmod(std::max(t - late, 0.0), 8.0) < 4.0 ? 1.0 : -1.0) * trapezoid(t - late));
    log.session.push_back(0);
    for (int k = 0; k < 20; ++k) angle += side * trapezoid(t + 5e-4 * k) * 5e-4;
  }
  return log;
}

TEST(VelocityLag, IsFoundInTrapezoidsBetweenRests) {
  const auto lag = recordTrapezoids(0.015).lag();
  ASSERT_TRUE(lag);
  EXPECT_NEAR(*lag, 0.015, 0.006);
}

TEST(VelocityLag, IsNoneWhereNothingIsLate) {
  EXPECT_FALSE(recordMotion(0.0, 0.0).lag());
  EXPECT_FALSE(recordMotion(0.0, 0.3).lag());
}

TEST(VelocityLag, IsNoneWhereTheTwoAreStrangers) {
  MotionLog log = recordMotion(0.02, 0.05);
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (double& v : log.velocity) v = normal(random);
  EXPECT_FALSE(log.lag());
}

TEST(Moved, PutsALateVelocityWhereItBelongs) {
  const MotionLog log = recordMotion(0.02, 0.0);
  const std::vector<double> v = moved(log.time, log.velocity, splitRuns(log.time, log.session), 0.02);
  for (std::size_t i = 0; i + 3 < 1500; ++i) ASSERT_NEAR(v[i], speedAt(log.time[i]), 0.005) << i;
}

}  // namespace
}  // namespace simgap
