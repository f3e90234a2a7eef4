// Long motions in pieces: each begins in the state that was measured there.
#include "simgap/measure/motion_restart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/error.h"

namespace simgap::test {
namespace {

const PoseLayout kBallAndHinge{{"m"}, {}, {{"shoulder", JointType::kSpherical}, {"elbow", JointType::kRevolute}}};
const Eigen::Vector3d kSpin(0.3, -0.5, 0.8);  // of the ball, in the child's frame [rad/s]

/// 9 s: a ball that turns evenly, a hinge and a shaft that swing.
RecordedMotion swingingArm() {
  RecordedMotion motion;
  motion.name = "swing";
  motion.commands.kinds = {CommandKind::kSetpoint};
  motion.muscles.resize(1);
  for (int i = 0; i <= 900; ++i) {
    motion.commands.times.push_back(0.01 * i);
    motion.muscles[0].shafts.push_back(std::sin(0.01 * i));
  }
  motion.commands.values = Eigen::MatrixXd::Constant(1, 901, 2.0);
  for (int i = 0; i < 540; ++i) {
    const double time = i / 60.0;
    motion.joint_times.push_back(time);
    motion.joints.push_back({{Eigen::Quaterniond(expSo3(kSpin * time)), 0.0},
                             {Eigen::Quaterniond::Identity(), 0.5 * std::sin(2.0 * time)}});
  }
  return motion;
}

TEST(MotionRestart, PiecesBeginInTheMeasuredState) {
  const RecordedMotion whole = swingingArm();
  const MotionSet pieces = restarted({"set.yaml", {whole}}, kBallAndHinge, 3.0);
  ASSERT_EQ(pieces.motions.size(), 3u);
  EXPECT_EQ(pieces.motions[0].name, "swing");
  EXPECT_FALSE(pieces.motions[0].start);
  const RecordedMotion& second = pieces.motions[1];
  EXPECT_EQ(second.name, "swing @ 3 s");
  EXPECT_NEAR(second.times().front(), 2.5, 1e-9);
  EXPECT_NEAR(second.times().back(), 6.0, 1e-9);
  EXPECT_NEAR(second.compared_from, 3.0, 1e-9);
  EXPECT_EQ(second.commands.values.cols(), std::ssize(second.times()));
  EXPECT_EQ(second.muscles[0].shafts.size(), second.times().size());
  EXPECT_GE(second.joint_times.front(), 2.5);
  ASSERT_TRUE(second.start);
  EXPECT_NEAR(second.start->joints[1].angle, 0.5 * std::sin(5.0), 1e-4);
  EXPECT_NEAR(second.start->joint_velocities[1].x(), std::cos(5.0), 0.01);  // the parabola's, over 0.2 s
  const Eigen::Quaterniond expected(expSo3(kSpin * 2.5));
  EXPECT_LT(second.start->joints[0].rotation.angularDistance(expected), 1e-6);
  EXPECT_LT((second.start->joint_velocities[0] - kSpin).norm(), 1e-3);
  EXPECT_NEAR(second.start->shafts[0], std::sin(2.5), 1e-4);
}

TEST(MotionRestart, ShortMotionsStayWhole) {
  EXPECT_EQ(restarted({"set.yaml", {swingingArm()}}, kBallAndHinge, 7.0).motions.size(), 1u);
}

TEST(MotionRestart, SaysWhereItCannotBegin) {
  RecordedMotion blind = swingingArm();
  for (std::size_t f = 130; f < 180; ++f) blind.joint_times[f] += 1.0;  // no frames about 2.5 s
  std::ranges::sort(blind.joint_times);
  try {
    restarted({"set.yaml", {blind}}, kBallAndHinge, 3.0);
    FAIL() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("frames around 2.50 s, expected at least 5"));
  }
  RecordedMotion deaf = swingingArm();
  deaf.commands.kinds = {CommandKind::kVoltage};
  deaf.muscles[0].shafts.clear();
  EXPECT_THROW(restarted({"set.yaml", {deaf}}, kBallAndHinge, 3.0), DataError);
}

}  // namespace
}  // namespace simgap::test
