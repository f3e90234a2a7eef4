// What of a gap on held-out motions is explained, by hand.
#include "diagnose/motions/motion_heldout.h"

#include <gtest/gtest.h>

#include <cmath>

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

/// A motion in which nothing is missing would make the mean gain of the others unsure.
TEST(MotionHeldOut, AGainIsOneOfMotionsThatMissSomething) {
  Eigen::MatrixXd before(1, 5), after(1, 5);
  before << 8.0, 8.0, 0.9, 8.0, 1.1;
  after << 2.0, 4.0, 1.0, 2.0, 1.1;
  const Eigen::ArrayXd gains = logGains(before, after);
  ASSERT_EQ(gains.size(), 3);
  EXPECT_DOUBLE_EQ(gains[0], std::log(4.0));
  EXPECT_DOUBLE_EQ(gains[1], std::log(2.0));
  EXPECT_GT(gainOf(gains).lower95, 0.0);
  after(0, 2) = 5.0;  // what a cause spoils speaks against it
  EXPECT_EQ(logGains(before, after).size(), 4);
  before(0, 3) = after(0, 3) = after(0, 2) = 1.0;  // of two no spread is known
  EXPECT_EQ(logGains(before, after).size(), 5);
}

// Hardly known parameters may move a joint of unseen motions by as much as it is missed; where the motions that set
// them are missed alike, they are not why. So a dragging cable passed for five times the dry friction, with nothing
// left.
TEST(MotionHeldOut, WhatTheFittedMotionsAreMissedByNoParameterExcuses) {
  EXPECT_FALSE(isLeft(16.4, 0.9, 21.2));
  EXPECT_TRUE(isLeft(16.4, 0.9, 9.0));
  EXPECT_TRUE(isLeft(16.4, 8.0, 21.2));
  EXPECT_FALSE(isLeft(2.0, 8.0, 0.0));  // no more than noise
}

}  // namespace
}  // namespace simgap
