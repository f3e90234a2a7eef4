#include "diagnose/arm_cause.h"

#include <gtest/gtest.h>

namespace simgap::test {
namespace {

TEST(ArmCause, IsDeterminedWhereOneOfItsSizesIsNotNone) {
  const ArmEffect &payload = *findArmEffect("payload"), &tilt = *findArmEffect("gravity-tilt"),
                  &gain = *findArmEffect("controller-gain");
  EXPECT_NE(doubtOfSize(payload, {{"mass", "kg", 0.04, 0.06}, {"distance", "m", 0.9, 0.01}}), "");  // a place is none
  EXPECT_EQ(doubtOfSize(payload, {{"mass", "kg", -0.2, 0.06}, {"distance", "m", 0.15, 0.1}}), "");
  EXPECT_EQ(doubtOfSize(tilt, {{"about_x", "rad", 0.01, 0.02}, {"about_y", "rad", 0.1, 0.02}}), "");
  EXPECT_NE(doubtOfSize(tilt, {{"about_x", "rad", 0.01, 0.02}, {"about_y", "rad", 0.03, 0.02}}), "");
  EXPECT_NE(doubtOfSize(gain, {{"factor", "1", 1.1, 0.06}}), "");  // none is a factor of 1
}

}  // namespace
}  // namespace simgap::test
