// Rests of an arm among its joint angles, and what the shafts did then.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  const Lag lag = estimateLag(twoRests(), kElbow, shaftsMovingAt(0.3), 0.5);  // the joint starts at 0.4 s
  EXPECT_NEAR(lag.seconds, 0.1, 0.01);
  EXPECT_GT(lag.correlation, 0.9);
}

}  // namespace
}  // namespace simgap::test
