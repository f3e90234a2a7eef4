// Channels that hang are told from channels that are at rest.
#include "diagnose/motions/motion_faults.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/arms.h"
#include "support/motions.h"

namespace simgap {
namespace {

class MotionFaults : public testing::Test {
 protected:
  static reality::Setpoints swings(std::uint64_t draw) { return test::opposedSwings(draw, {0.2, 0.7, 0.3, 0.8, 95}); }

  MotionFaults() {
    for (std::size_t k = 0; k < times().size(); ++k) {  // where the first set-point moves most within a second
      std::size_t end = k;
      while (end < times().size() && times()[end] < times()[k] + 1.0) ++end;
      if (end == times().size()) break;
      const double moves = std::abs(motion().commands.values(0, end) - motion().commands.values(0, k));
      if (moves <= most_) continue;
      most_ = moves;
      begin_ = k;
      end_ = end;
    }
  }

  RecordedMotion& motion() { return set_.motions.front(); }
  const std::vector<double>& times() { return motion().times(); }
  std::vector<DataFault> find() {
    std::vector<bool> faulty;
    return findMotionFaults(set_, model_.poseLayout(), faulty);
  }

  const ArmModel model_ = test::modelOf(test::movingForearm().arm, true);
  MotionSet set_ = test::recordMotions(test::trueForearm(), model_, swings, 0, 1, {});
  std::size_t begin_ = 0, end_ = 0;  ///< rows
  double most_ = 0.0;                ///< [rad]
};

TEST_F(MotionFaults, AnEncoderAtRestShowsOneCount) {
  // A second at rest before the motion, to the last digit.
  const double count = 2.0 * std::numbers::pi / 1024.0;
  for (MuscleRecord& muscle : motion().muscles) {
    for (double& shaft : muscle.shafts) shaft = count * std::round(shaft / count);
  }
  const auto rows =
      static_cast<std::size_t>(std::ranges::lower_bound(times(), times().front() + 1.0) - times().begin());
  for (std::size_t m = 0; m < motion().muscles.size(); ++m) {
    std::fill_n(motion().muscles[m].shafts.begin(), rows, motion().muscles[m].shafts[rows]);
    std::fill_n(motion().muscles[m].currents.begin(), rows, 0.0);
    for (std::size_t k = 0; k < rows; ++k) motion().commands.values(m, k) = motion().commands.values(m, rows);
  }
  EXPECT_TRUE(find().empty()) << find().front().sentence;
}

TEST_F(MotionFaults, AShaftThatHangsWhileItsSetpointMovesIsOne) {
  ASSERT_GT(most_, 0.3);
  std::vector<double>& shafts = motion().muscles[0].shafts;
  for (std::size_t k = begin_; k < end_; ++k) shafts[k] = shafts[begin_];
  ASSERT_EQ(find().size(), 1U);
  EXPECT_EQ(find().front().channel, "shaft_muscle1_rad");
  EXPECT_NE(find().front().sentence.find("repeats one reading"), std::string::npos);
}

TEST_F(MotionFaults, ACaptureThatHangsWhileShaftsMoveIsOne) {
  ASSERT_GT(most_, 0.3);
  std::vector<std::vector<JointPosition>>& joints = motion().joints;
  const std::vector<JointPosition>* held = nullptr;
  for (std::size_t f = 0; f < joints.size(); ++f) {
    if (motion().joint_times[f] < times()[begin_] || motion().joint_times[f] > times()[end_]) continue;
    if (held == nullptr) held = &joints[f];
    joints[f] = *held;
  }
  ASSERT_EQ(find().size(), model_.poseLayout().joints.size());
  EXPECT_EQ(find().front().channel, "joint " + model_.poseLayout().joints.front().name);
}

}  // namespace
}  // namespace simgap
