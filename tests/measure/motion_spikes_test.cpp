// Readings that no arm can have reached, among those of one that moves.
#include "measure/motion_spikes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

const PoseLayout kArm{{"biceps"}, {}, {{"shoulder", JointType::kSpherical}, {"elbow", JointType::kRevolute}}};

/// Steps that are rounded by an arm's inertia, with a capture's noise.
RecordedMotion movement() {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  RecordedMotion motion;
  motion.name = "wave";
  motion.muscles.resize(1);
  for (int i = 0; i < 240; ++i) {
    const double t = i / 60.0, step = std::tanh(8.0 * (t - 1.0)) - std::tanh(6.0 * (t - 2.5));
    const auto noise = [&] { return 0.003 * normal(random); };
    motion.joint_times.push_back(t);
    const Eigen::Vector3d turn{0.4 * step + noise(), 0.2 * t + noise(), noise()};
    motion.joints.push_back({{.rotation = Eigen::Quaterniond(expSo3(turn))}, {.angle = 1.0 + 0.5 * step + noise()}});
    motion.commands.times.push_back(t);
    motion.muscles[0].shafts.push_back(3.0 + 2.0 * step + 0.1 * noise());
  }
  return motion;
}

TEST(MotionSpikes, NoneInAMovement) {
  RecordedMotion motion = movement();
  EXPECT_EQ(repairMotionSpikes(motion, kArm).count, 0U);
  EXPECT_EQ(sayLoneReadings({{}, {}}), "");
  EXPECT_EQ(motion.joints[60][1].angle, movement().joints[60][1].angle);
}

TEST(MotionSpikes, AreReplacedByWhatLiesBetweenTheirNeighboursAndCounted) {
  RecordedMotion motion = movement();
  motion.joints[100][1].angle += 0.4;
  motion.joints[150][0].rotation =
      Eigen::Quaterniond(expSo3(Eigen::Vector3d(0.5, 0.0, 0.0))) * motion.joints[150][0].rotation;
  motion.muscles[0].shafts[30] -= 1.0;
  const LoneReadings lone = repairMotionSpikes(motion, kArm);
  EXPECT_EQ(lone.count, 3U);
  EXPECT_EQ(lone.where, "wave: 1 of 240 of shoulder, 1 of 240 of elbow, 1 of 240 of the shaft of biceps");
  EXPECT_THAT(sayLoneReadings({{1, "one"}, lone, {}}), HasSubstr(": 4 in 2 of 3 motions; most of motion wave: "));
  const RecordedMotion before = movement();
  EXPECT_NEAR(motion.joints[100][1].angle, before.joints[100][1].angle, 0.02);
  EXPECT_LT(kindOf(JointType::kSpherical).error(motion.joints[150][0], before.joints[150][0]), 0.02);
  EXPECT_NEAR(motion.muscles[0].shafts[30], before.muscles[0].shafts[30], 0.01);
}

}  // namespace
}  // namespace simgap::test
