// What a channel is before physics.
#include "simgap/measure/logs/channel_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/files.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// `levels` values from -1 to 1, each held for 40 rows, in turn.
std::vector<double> steps(int levels) {
  std::vector<double> values;
  for (int i = 0; i < 2000; ++i) values.push_back(-1.0 + 2.0 * (i / 40 % levels) / (levels - 1));
  return values;
}

TEST(ChannelChecks, ACommandOfStepsIsNotClipped) {
  EXPECT_THAT(checkChannels("log.csv", std::vector<ChannelCheck>{{"voltage_V", steps(2), 100.0}}), IsEmpty());
  std::vector<double> clipped;
  for (int i = 0; i < 2000; ++i) clipped.push_back(std::min(0.7, std::sin(0.01 * i)));
  EXPECT_THAT(checkChannels("log.csv", std::vector<ChannelCheck>{{"voltage_V", clipped, 100.0}}), SizeIs(1));
}

TEST(ChannelChecks, StepsSayNothingOfADrive) {
  EXPECT_THAT(errorOf([] { requireMoreThanSteps("log.csv", "motor_voltage_V", steps(2)); }),
              HasSubstr("log.csv: motor_voltage_V takes 2 different values"));
  EXPECT_THAT(errorOf([] { requireMoreThanSteps("log.csv", "motor_voltage_V", steps(6)); }), HasSubstr("takes 6"));
  requireMoreThanSteps("log.csv", "motor_voltage_V", steps(7));
}

}  // namespace
}  // namespace simgap::test
