#include "diagnose/logs/measured_sizes.h"

#include <gtest/gtest.h>

namespace simgap::test {
namespace {

/// Nothing but what a newton metre of load makes a motor draw. \param k_a  [N m/A]
Fitted drawing(double k_a) {
  Fitted fitted;
  fitted.theta = {1.0 / k_a};
  return fitted;
}

TEST(MeasuredSizes, ACauseThatMakesTheMeasuredLoadCountForLessReplacesIt) {
  ActuatorRows rows;
  rows.load_measured = true;
  rows.top_load = 5.0;
  EXPECT_EQ(loadItReplaces(drawing(0.97), drawing(3.32), rows),
            "it takes the place of the measured load: k_a would be 3.32 with it, and is 0.97 without");
  EXPECT_EQ(loadItReplaces(drawing(0.97), drawing(1.1), rows), "");
  EXPECT_EQ(loadItReplaces(drawing(0.97), drawing(0.5), rows), "");
  rows.load_measured = false;  // a weight that is only believed may be wrong
  EXPECT_EQ(loadItReplaces(drawing(0.97), drawing(3.32), rows), "");
}

}  // namespace
}  // namespace simgap::test
