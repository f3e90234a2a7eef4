// What of a gap on held-out motions is explained, by hand.
#include "diagnose/motions/motion_heldout.h"

#include <gtest/gtest.h>

namespace simgap {
namespace {

/// A group per row, a motion per column; a floor of 1.
TEST(MotionHeldOut, MotionsThatMissedNothingSayNothing) {
  const Eigen::ArrayXd floor = Eigen::ArrayXd::Ones(5);
  Eigen::MatrixXd before(1, 5), after(1, 5);
  before << 5.0, 9.0, 0.8, 0.9, 1.0;
  after << 3.0, 5.0, 0.7, 0.9, 0.9;
  EXPECT_DOUBLE_EQ(explainedShare(before, after, floor), 0.5);  // (5 - 3)/(5 - 1), (9 - 5)/(9 - 1)
  before.setConstant(0.5);
  EXPECT_DOUBLE_EQ(explainedShare(before, after, floor), 0.0);
}

}  // namespace
}  // namespace simgap
