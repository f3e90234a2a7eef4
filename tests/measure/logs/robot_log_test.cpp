// Which rows of a robot's joint say what its friction in motion is.
#include "simgap/measure/logs/robot_log.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "simgap/core/error.h"

namespace simgap {
namespace {

/// 60 s at 100 Hz: 2 s forwards, 1 s at rest, 2 s back, 1 s at rest, between ramps of 80 ms.
RobotLog recordStops(bool velocity, std::optional<double> presliding = {}) {
  std::string csv = velocity ? "time_s,j1_rad,torque_j1_Nm,j1_velocity_rad_s\n" : "time_s,j1_rad,torque_j1_Nm\n";
  double position = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const int phase = i % 300;
    const double v = (i % 600 < 300 ? 1.0 : -1.0) * std::clamp(std::min(phase, 200 - phase) / 8.0, 0.0, 1.0);
    position += 0.01 * v;
    csv += fmt::format("{:.2f},{:.6f},{:.4f}", 0.01 * i, position, 0.5 * v + 0.3 * std::sin(0.07 * i));
    csv += velocity ? fmt::format(",{:.4f}\n", v) : "\n";
  }
  const std::vector<LoggedJoint> joints = {{"j1", false, -10.0, 10.0, presliding}};
  return readRobotLog(CsvTable::parse(csv, "log.csv"), joints);
}

/// Velocity is smoothed and acceleration worked out in either case.
TEST(RobotLogTest, RowsBesideRestsAreBlurredWhereVelocityWasMeasuredToo) {
  for (const bool velocity : {false, true}) {
    const RobotLog log = recordStops(velocity);
    const RobotJointLog& joint = log.joints[0];
    const int blurred = static_cast<int>(0.3 / joint.bandwidth * 100.0);
    ASSERT_GE(blurred, 2) << joint.bandwidth;
    for (const int stop : {1400, 1700, 2000}) {
      for (int k = 1; k <= blurred; ++k) EXPECT_FALSE(joint.moves[stop - k]) << velocity << " " << stop - k;
    }
    EXPECT_TRUE(joint.moves[1300]);
  }
}

/// Dry friction that is there at once, and a velocity of 1 rad/s and a noise of 0.02: its turns are rows beside those
/// of the position, and seen from there friction seemed to build up over most of the way.
TEST(RobotLogTest, ANoisyVelocityTakesNoMotionForRest) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 0.02);
  std::string csv = "time_s,j1_rad,torque_j1_Nm,j1_velocity_rad_s\n";
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.01 * i, position = std::sin(1.3 * t) / 1.3, velocity = std::cos(1.3 * t);
    const double torque = 2.0 * std::sin(position) + 0.4 * std::copysign(1.0, velocity) + noise(random);
    csv += fmt::format("{:.2f},{:.6f},{:.4f},{:.4f}\n", t, position, torque, velocity + noise(random));
  }
  const std::vector<LoggedJoint> joints = {{"j1", false, -10.0, 10.0, {}}};
  const RobotLog log = readRobotLog(CsvTable::parse(csv, "log.csv"), joints);
  EXPECT_LT(log.joints[0].resting, 200U);
}

// Smoothed less on the stamps as they came: differences of the two made intervals of inertias twenty times too wide.
TEST(RobotLogTest, StampsThatJitterArePutRightForTheSharperMotion) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::string csv = "time_s,j1_rad,torque_j1_Nm\n";
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.004 * i, stamp = t + 4e-4 * noise(random);
    const double position = std::sin(2.1 * t) + 0.3 * std::sin(5.3 * t + 1.0), torque = 2.0 * position;
    csv += fmt::format("{:.6f},{:.6f},{:.4f}\n", stamp, position, torque + 0.02 * noise(random));
  }
  const std::vector<LoggedJoint> joints = {{"j1", false, -10.0, 10.0, {}}};
  const RobotJointLog joint = readRobotLog(CsvTable::parse(csv, "log.csv"), joints).joints[0];
  double apart = 0.0, all = 0.0;
  for (std::size_t i = 500; i < 5500; ++i) {
    apart += std::pow(joint.sharper_acceleration[i] - joint.acceleration[i], 2);
    all += std::pow(joint.acceleration[i], 2);
  }
  EXPECT_LT(std::sqrt(apart / all), 0.05);
}

TEST(RobotLogTest, AJointThatMovesWithoutEffortHasNoSensor) {
  std::string csv = "time_s,j1_rad,torque_j1_Nm\n";
  for (int i = 0; i < 600; ++i) csv += fmt::format("{:.2f},{:.6f},0\n", 0.01 * i, std::sin(0.05 * i));
  const std::vector<LoggedJoint> joints = {{"j1", false, -10.0, 10.0, {}}};
  std::string sentence;
  try {
    readRobotLog(CsvTable::parse(csv, "log.csv"), joints);
  } catch (const DataError& error) {
    sentence = error.what();
  }
  EXPECT_EQ(sentence, "log.csv: the effort of joint j1 is 0 in every row while it moves, expected what moved it");
}

/// A delay of the effort hides how friction builds up; what is known of that from another log still counts.
TEST(RobotLogTest, KnownPreslidingIsLeftOutWhereTheLogShowsNone) {
  const RobotJointLog plain = recordStops(true).joints[0], known = recordStops(true, 0.5).joints[0];
  EXPECT_LT(plain.presliding, 0.01);
  EXPECT_EQ(known.presliding, 0.5);
  for (const int start : {1200, 1500, 1800}) {
    EXPECT_TRUE(plain.moves[start + 45]);
    EXPECT_FALSE(known.moves[start + 45]);
    EXPECT_TRUE(known.moves[start + 70]);
  }
}

/// 20 s of a joint that swings, its velocity times a factor and late by a part of the period, its stamps in `unit`
/// [1/s].
void readSwing(double factor, double late, double unit = 1.0) {
  std::string csv = "time_s,j1_rad,torque_j1_Nm,j1_velocity_rad_s\n";
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.01 * i;
    csv += fmt::format("{:.2f},{:.6f},{:.4f},{:.6f}\n", unit * t, std::sin(2.0 * t), std::cos(0.3 * t),
                       2.0 * factor * std::cos(2.0 * t - late));
  }
  readRobotLog(CsvTable::parse(csv, "log.csv"), std::vector<LoggedJoint>{{"j1", false, -10.0, 10.0, {}}});
}

std::string sentenceOf(double factor, double late, double unit = 1.0) {
  try {
    readSwing(factor, late, unit);
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

TEST(RobotLogTest, AVelocityIsTheSlopeOfItsPosition) {
  EXPECT_NO_THROW(readSwing(1.0, 0.05));
  EXPECT_THAT(sentenceOf(57.29578, 0.0), testing::HasSubstr("joint j1 that is 57.3 times the slope of its position"));
  EXPECT_THAT(sentenceOf(57.29578, 0.0), testing::HasSubstr("_deg_s"));
  EXPECT_THAT(sentenceOf(-1.0, 0.0), testing::HasSubstr("that is -0.999 times"));
  EXPECT_THAT(sentenceOf(1.0, 1.5), testing::HasSubstr("expected columns of one joint"));  // another joint's
}

TEST(RobotLogTest, StampsInMillisecondsAreNoSeconds) {
  EXPECT_THAT(sentenceOf(1.0, 0.0, 1e3),
              testing::AllOf(testing::HasSubstr("found rows 10 s apart"), testing::HasSubstr("the column is time_ms")));
}

}  // namespace
}  // namespace simgap
