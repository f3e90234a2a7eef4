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
  for (SteadyPose& pose : poses) EXPECT_TRUE(joinShafts(pose, shaftsMovingAt(0.4)));
  EXPECT_NEAR(poses[0].shafts[0], 0.0, 1e-12);
  EXPECT_NEAR(poses[1].shafts[0], 1.0, 1e-12);
  CsvWriter csv = posesCsv(kElbow, {"biceps"});
  EXPECT_THAT(csv.text(), HasSubstr("pose,repeat,time_s,shaft_biceps_rad,elbow_rad"));
  addPose(csv, 7, poses[1], kElbow);
  EXPECT_THAT(csv.text(), HasSubstr("\np007,0,"));
}

TEST(SteadyPoses, ALogThatEndsEarlyLosesThePoses) {
  std::vector<SteadyPose> poses = findSteadyPoses(twoRests(), kElbow, {});
  ShaftLog log = shaftsMovingAt(0.4);
  log.times.resize(50);
  log.shafts[0].resize(50);
  EXPECT_EQ(std::ranges::count_if(poses, [&](SteadyPose& pose) { return joinShafts(pose, log); }), 1);
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
  std::size_t most = 0, most_rests = 0;
  RestSpool rests;
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
    const std::vector<SteadyPose> ended = finder.take();
    most_rests = std::max(most_rests, ended.size());
    for (const SteadyPose& rest : ended) rests.add(rest);
  }
  for (const SteadyPose& rest : finder.finish()) rests.add(rest);
  EXPECT_LT(most, 100u);
  EXPECT_EQ(most_rests, 1u);
  ASSERT_EQ(rests.size(), 2000u);
  for (std::size_t p = 0; p < rests.size(); ++p) {
    const SteadyPose rest = rests.at(p);
    EXPECT_NEAR(rest.joints[0].angle, p % 2 == 0 ? 0.0 : 1.0, 1e-3) << p;
    EXPECT_NEAR(rest.start, static_cast<double>(p), 0.05) << p;
  }
}

TEST(RestSpool, GivesBackWhatItWasGiven) {
  std::vector<SteadyPose> poses = findSteadyPoses(twoRests(), kElbow, {});
  for (SteadyPose& pose : poses) ASSERT_TRUE(joinShafts(pose, shaftsMovingAt(0.4)));
  RestSpool spool;
  for (const SteadyPose& pose : poses) spool.add(pose);
  ASSERT_EQ(spool.size(), poses.size());
  for (const std::size_t p : {1u, 0u, 1u}) {
    const SteadyPose rest = spool.at(p);
    EXPECT_EQ(rest.first_frame, poses[p].first_frame);
    EXPECT_EQ(rest.last_frame, poses[p].last_frame);
    EXPECT_EQ(rest.start, poses[p].start);
    EXPECT_EQ(rest.end, poses[p].end);
    EXPECT_EQ(rest.samples, poses[p].samples);
    EXPECT_EQ(rest.joints.front().angle, poses[p].joints.front().angle);
    EXPECT_EQ(rest.joints.front().rotation.coeffs(), poses[p].joints.front().rotation.coeffs());
    EXPECT_EQ(rest.spread, poses[p].spread);
    EXPECT_EQ(rest.shafts, poses[p].shafts);
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
