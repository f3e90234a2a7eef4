// Rests of an arm among its joint angles, and what the shafts did then.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simgap/capture/capture_run.h"
#include "simgap/capture/steady_poses.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

/// 60 Hz; one revolute joint that rests, moves for 0.2 s, and rests again.
std::vector<JointSample> twoRests() {
  std::vector<JointSample> samples;
  for (int i = 0; i < 60; ++i) {
    JointPosition position;
    position.angle = 0.5 * std::clamp((i - 24) / 12.0, 0.0, 1.0);
    samples.push_back({std::size_t(i), i / 60.0, {position}, {0.0}, {0.0}});
  }
  return samples;
}

const std::vector<CaptureJoint> kElbow = {{"elbow", JointType::kRevolute, 0, 1, Eigen::Vector3d::UnitX()}};

ShaftLog shaftsMovingAt(double start) {
  std::string csv = "time_s,shaft_biceps_rad\n";
  for (int i = 0; i < 100; ++i) {
    csv += std::to_string(i / 100.0) + "," + std::to_string(std::clamp((i / 100.0 - start) / 0.2, 0.0, 1.0)) + "\n";
  }
  return readShaftLog(CsvTable::parse(csv, "shafts.csv"));
}

TEST(SteadyPoses, FindsTheRestsAndWhatTheShaftsDid) {
  std::vector<SteadyPose> poses = findSteadyPoses(twoRests(), kElbow, {});
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].first_frame, 0u);
  EXPECT_EQ(poses[0].last_frame, 24u);
  EXPECT_EQ(poses[1].first_frame, 36u);
  EXPECT_EQ(poses[1].last_frame, 59u);
  EXPECT_NEAR(poses[1].joints[0].angle, 0.5, 1e-12);
  EXPECT_EQ(joinShafts(poses, shaftsMovingAt(0.4)), 0u);
  EXPECT_NEAR(poses[0].shafts[0], 0.0, 1e-12);
  EXPECT_NEAR(poses[1].shafts[0], 1.0, 1e-12);
  EXPECT_THAT(posesCsv(poses, kElbow, {"biceps"}), HasSubstr("pose,repeat,time_s,shaft_biceps_rad,elbow_rad"));
}

TEST(SteadyPoses, ALogThatEndsEarlyLosesThePoses) {
  std::vector<SteadyPose> poses = findSteadyPoses(twoRests(), kElbow, {});
  ShaftLog log = shaftsMovingAt(0.4);
  log.times.resize(50);
  log.shafts[0].resize(50);
  EXPECT_EQ(joinShafts(poses, log), 1u);
  EXPECT_EQ(poses.size(), 1u);
}

TEST(SteadyPoses, FindsTheLagOfTheJointsBehindTheShafts) {
  JointSpeeds speeds(kElbow);
  for (const JointSample& sample : twoRests()) speeds.add(sample);
  const Lag lag = estimateLag(speeds, shaftsMovingAt(0.3), 0.5);  // the joint starts at 0.4 s
  EXPECT_NEAR(lag.seconds, 0.1, 0.01);
  EXPECT_GT(lag.correlation, 0.9);
}

/// 100,000 pairs at 50 Hz: half a second of rest, half a second of motion.
TEST(SteadyPoses, ALongMotionTakesNoMoreMemoryThanAShortOne) {
  RestFinder finder(kElbow, {});
  std::size_t most = 0;
  for (std::size_t i = 0; i < 100'000; ++i) {
    const double phase = static_cast<double>(i % 50) / 50.0, done = static_cast<double>(i / 50);
    JointSample sample;
    sample.frame = i;
    sample.time = static_cast<double>(i) / 50.0;
    sample.joints.resize(1);
    sample.joints[0].angle = (static_cast<long>(done) % 2 == 0 ? 1.0 : -1.0) * std::clamp(2.0 * phase - 1.0, 0.0, 1.0) +
                             (static_cast<long>(done) % 2 == 0 ? 0.0 : 1.0);
    finder.add(sample);
    most = std::max(most, finder.samplesKept());
  }
  EXPECT_LT(most, 100u);
  const std::vector<SteadyPose> poses = finder.finish();
  ASSERT_EQ(poses.size(), 2000u);
  for (std::size_t p = 0; p < poses.size(); ++p) {
    EXPECT_NEAR(poses[p].joints[0].angle, p % 2 == 0 ? 0.0 : 1.0, 1e-3) << p;
    EXPECT_NEAR(poses[p].start, static_cast<double>(p), 0.05) << p;
  }
}

TEST(LatencyCounts, QuantilesAreThoseOfTheSortedListWithinOnePercent) {
  LatencyCounts counts;
  std::vector<double> all;
  for (int i = 0; i < 10'000; ++i) {
    all.push_back(2e-3 * std::exp(2.0 * std::sin(0.37 * i)));
    counts.add(all.back());
  }
  std::sort(all.begin(), all.end());
  for (const double part : {0.0, 0.5, 0.95}) {
    const double expected = all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
    EXPECT_NEAR(counts.quantile(part), expected, 0.01 * expected) << part;
  }
  EXPECT_EQ(counts.quantile(1.0), all.back());
}

}  // namespace
}  // namespace simgap::test
