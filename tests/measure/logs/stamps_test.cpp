// Stamps that jitter while the samples do not, and what only looks like that.
#include "simgap/measure/logs/stamps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "simgap/measure/logs/friction_rows.h"
#include "simgap/measure/logs/motion.h"
#include "support/current_log.h"

namespace simgap {
namespace {

struct StampedLog {
  std::vector<double> sampled, stamped, angle;  ///< when a row was read, when the log says so, what was read
  std::vector<int> session;

  std::optional<EvenTimes> even() const { return evenTimes(stamped, angle, splitRuns(stamped, session)); }
};

double angleAt(double t) { return 2.0 * std::sin(0.7 * t) + 0.5 * std::sin(3.1 * t); }

/// 2000 rows at 50 Hz. \param stamps, samples  sizes of their jitter [s]. \param count  of the encoder [rad].
StampedLog recordStamps(double stamps, double samples, double count, std::size_t lost_after = 0) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  StampedLog log;
  for (std::size_t i = 0; i < 2000; ++i) {
    const std::size_t tick = lost_after > 0 && i > lost_after ? i + 3 : i;
    const double even = 0.02 * static_cast<double>(tick) * (1.0 + 1e-5 * static_cast<double>(i));  // the clock drifts
    const double late = std::clamp(normal(random), -3.0, 3.0);
    log.sampled.push_back(even + samples * late);
    log.stamped.push_back(even + (samples > 0.0 ? samples : stamps) * late);
    log.angle.push_back(count * std::round(angleAt(log.sampled.back()) / count));
    log.session.push_back(0);
  }
  return log;
}

double worst(std::span<const double> a, std::span<const double> b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST(EvenTimes, AreTakenWhereOnlyTheStampsJitter) {
  const StampedLog log = recordStamps(1.5e-3, 0.0, 1e-4);
  const auto even = log.even();
  ASSERT_TRUE(even);
  EXPECT_NEAR(even->jitter, 1.5e-3, 2e-4);
  EXPECT_GT(even->times_smoother, 4.0);
  EXPECT_GT(worst(log.stamped, log.sampled), 4e-3);
  EXPECT_LT(worst(even->time, log.sampled), 1.5e-3);
}

TEST(EvenTimes, AreNotWhereTheSamplesJitterWithTheirStamps) { EXPECT_FALSE(recordStamps(0.0, 1.5e-3, 1e-4).even()); }

TEST(EvenTimes, AreNotWhereRoundingHidesTheDifference) { EXPECT_FALSE(recordStamps(1.5e-3, 0.0, 0.05).even()); }

TEST(EvenTimes, AreNotWhereStampsDoNotJitter) { EXPECT_FALSE(recordStamps(0.0, 0.0, 1e-4).even()); }

TEST(EvenTimes, KeepSamplesThatWereLost) {
  const StampedLog log = recordStamps(1.5e-3, 0.0, 1e-4, 900);
  const auto even = log.even();
  ASSERT_TRUE(even);
  EXPECT_LT(worst(even->time, log.sampled), 2.5e-3);
  EXPECT_NEAR(even->time[901] - even->time[900], 0.08, 4e-3);
}

ActuatorLog driveLog(const StampedLog& log) {
  ActuatorLog drive = test::currentLog("log.csv");
  drive.time = log.stamped;
  drive.position = log.angle;
  drive.session = log.session;
  drive.session_names = {"0"};
  for (std::size_t i = 0; i < log.angle.size(); ++i) drive.effort.push_back(1.0 + 0.5 * std::sin(0.013 * double(i)));
  return drive;
}

Bench freeAxis() {
  Bench bench;
  bench.load = BenchLoad::kFreeAxis;
  bench.inertia = {.value = 0.0, .fitted = true};
  bench.bandwidth = 8.0;
  return bench;
}

double velocityError(const StampedLog& log, FrictionData& data) {
  FrictionDataOptions options;
  options.all_rows = true;
  data = prepareFrictionData(driveLog(log), freeAxis(), options);
  double sum = 0.0;
  for (std::size_t i = 20; i + 20 < log.sampled.size(); ++i) {
    const double t = log.sampled[i], truth = 1.4 * std::cos(0.7 * t) + 1.55 * std::cos(3.1 * t);
    sum += std::pow(data.velocity[i] - truth, 2);
  }
  return std::sqrt(sum / static_cast<double>(log.sampled.size() - 40));
}

TEST(EvenTimes, GiveTheVelocityThatEvenStampsWouldHaveGiven) {
  FrictionData jittering, even;
  const double with_jitter = velocityError(recordStamps(1.5e-3, 0.0, 1e-4), jittering);
  const double without = velocityError(recordStamps(0.0, 0.0, 1e-4), even);
  EXPECT_LT(with_jitter, 1.5 * without + 0.002);
  EXPECT_TRUE(std::ranges::any_of(
      jittering.warnings, [](const std::string& w) { return w.find("time_s jitters by 1.") != std::string::npos; }));
  EXPECT_TRUE(std::ranges::none_of(even.warnings, [](const std::string& w) { return w.find("jitters") < w.size(); }));
}

TEST(UsualStep, IsThatOfMostRowsWhereverSomeAreMissing) {
  EXPECT_EQ(usualStep(std::vector{0.0, 0.25, 0.5, 5.0, 5.25, 9.0, 9.25}), 0.25);
  EXPECT_EQ(usualStep(std::vector{3.0}), 0.0);
  EXPECT_EQ(usualStep({}), 0.0);
}

}  // namespace
}  // namespace simgap
