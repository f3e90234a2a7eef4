// What is said of a motion: where it is missed most, and which delays are none.
#include "diagnose/motions/motion_evidence.h"

#include <gtest/gtest.h>

#include "simgap/core/rotation.h"

namespace simgap {
namespace {

TEST(MotionEvidence, AMotionIsMissedMostWhereItIsMissedMostInItsNoise) {
  const PoseLayout layout{{"biceps"}, {}, {{"elbow", JointType::kRevolute}}};
  const MotionNoise noise{{1.0 * kDegree}, 0.25 * kDegree, 0.03};
  constexpr int kRows = 30;
  RecordedMotion motion;
  PlayedMotion played;
  played.valid = true;
  played.shafts = Eigen::MatrixXd::Constant(1, kRows, 1.0 * kDegree);
  played.currents = Eigen::MatrixXd::Constant(1, kRows, 3.0);  // drives leave more there: said otherwise
  motion.muscles.emplace_back();
  for (int row = 0; row < kRows; ++row) {
    motion.commands.times.push_back(0.1 * row);
    motion.joint_times.push_back(0.1 * row);
    motion.joints.emplace_back(1);
    motion.muscles[0].shafts.push_back(0.0);
    motion.muscles[0].currents.push_back(0.0);
    played.joints.push_back({Eigen::Quaterniond::Identity(), 1.5 * kDegree});
  }
  EXPECT_EQ(worstMoment(motion, played, layout, noise), "the shaft of biceps, 1.00 deg in the second from 0.0 s on");
  for (JointPosition& joint : played.joints) joint.angle = 9.0 * kDegree;
  EXPECT_EQ(worstMoment(motion, played, layout, noise), "elbow, 9.00 deg in the second from 0.0 s on");
}

TEST(MotionEvidence, ADelayThatReachesNoneWithARowIsNone) {
  Estimate delay;
  delay.name = "delay";
  delay.value = 0.0115;
  delay.sd = 0.0005;
  EXPECT_EQ(doubtOfDelay(delay, 0.01), "");
  delay.sd = 0.001;  // 11.5 ms of which 12.0 may be chance and the row
  EXPECT_NE(doubtOfDelay(delay, 0.01).find("may be none"), std::string::npos);
}

}  // namespace
}  // namespace simgap
