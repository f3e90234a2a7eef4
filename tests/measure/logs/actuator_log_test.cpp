#include "simgap/measure/logs/actuator_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/channel_checks.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

ActuatorLog readLog(const std::string& csv, const ActuatorLogOptions& options = {}) {
  return readActuatorLog(CsvTable::parse(csv, "log.csv"), options);
}

TEST(ActuatorLog, ReadsUnitsSessionsAndOptionalChannels) {
  const ActuatorLog log = readLog(
      "time_ms,motor_current_mA,motor_velocity_rpm,external_torque_mNm,session\n"
      "0,1000,60,500,a\n20,2000,-60,250,a\n0,3000,0,0,b\n");
  EXPECT_THAT(log.effort, ElementsAre(1.0, 2.0, 3.0));
  EXPECT_NEAR(log.velocity[0], 6.283185307, 1e-8);
  EXPECT_THAT(log.load, ElementsAre(0.5, 0.25, 0.0));
  EXPECT_THAT(log.session, ElementsAre(0, 0, 1));
  EXPECT_THAT(log.session_names, ElementsAre("a", "b"));
  EXPECT_THAT(log.position, IsEmpty());
}

TEST(ActuatorLog, ReadsLinearAxesAndOtherEfforts) {
  const ActuatorLog axis = readLog("time_s,motor_force_N,position_m\n0,1,0\n1,2,0.1\n");
  EXPECT_TRUE(axis.linear);
  EXPECT_EQ(axis.effort_unit, "N");
  const ActuatorLog servo = readLog("time_s,motor_voltage_V,position_deg\n0,1,0\n1,2,180\n");
  EXPECT_EQ(servo.effort_unit, "V");
  EXPECT_NEAR(servo.position[1], 3.14159265, 1e-8);
}

TEST(ActuatorLog, JointChannelsNeedTheRatio) {
  const std::string csv = "motor_current_A,joint_velocity_rad_s,external_torque_Nm\n1,0.5,2\n2,1,3\n";
  EXPECT_THAT(errorOf([&] { readLog(csv); }), HasSubstr("expected --ratio"));
  EXPECT_THAT(readLog(csv, {.ratio = 10.0}).velocity, ElementsAre(5.0, 10.0));
}

TEST(ActuatorLog, RefusesTimeThatGoesBack) {
  EXPECT_THAT(errorOf([] { readLog("time_s,motor_current_A,motor_velocity_rad_s\n0,1,1\n2,1,2\n1,1,3\n"); }),
              HasSubstr("log.csv:4: time goes from 2 s to 1 s"));
  EXPECT_THAT(errorOf([] { readLog("time_s,motor_current_A\n0,1\n"); }), HasSubstr("found no motor_velocity_rad_s"));
}

TEST(Blocks, StayWithinSessionsAndJumpsOfTime) {
  const std::vector<double> time = {0, 1, 2, 3, 100, 101, 0, 1};
  const std::vector<int> session = {0, 0, 0, 0, 0, 0, 1, 1};
  const std::vector<Block> blocks = splitBlocks(time, session, 2.0);
  ASSERT_EQ(blocks.size(), 4u);
  EXPECT_EQ(blocks[0].end, 2u);
  EXPECT_EQ(blocks[1].end, 4u);
  EXPECT_EQ(blocks[2].end, 6u);
  EXPECT_EQ(blocks[3].end, 8u);
}

TEST(LogChecks, NameImplausibleClippedAndStuckChannels) {
  std::vector<double> values(1000);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = std::min(3.0 * std::sin(0.05 * static_cast<double>(i)), 2.0);
  const auto check = [&](double plausible) {
    const ChannelCheck channel[] = {{"motor_current_A", values, plausible}};
    return checkChannels("log.csv", channel);
  };
  EXPECT_THAT(check(100.0), ElementsAre(HasSubstr("looks clipped")));
  EXPECT_THAT(errorOf([&] { check(1.0); }), HasSubstr("is the unit in the column's name right"));
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = i > 300 && i < 500 ? 0.123 : std::sin(0.05 * static_cast<double>(i));
  EXPECT_THAT(check(100.0), ElementsAre(HasSubstr("looks stuck")));
}

/// A motor that settles at its top speed, each way, read off an encoder: counts per row are a coarse grid.
TEST(LogChecks, ATopSpeedOnTheGridOfAnEncoderIsNoLimit) {
  constexpr double kCount = 0.05;  // [rad/s]
  std::vector<double> steady(2000), cut(2000);
  for (std::size_t i = 0; i < steady.size(); ++i) {
    const double since = static_cast<double>(i % 200), side = i / 200 % 2 == 0 ? 1.0 : -1.0;
    const double speed = 4.3 * side * (1.0 - 2.0 * std::exp(-since / 5.0));
    steady[i] = kCount * std::round(speed / kCount);
    cut[i] = kCount * std::round(std::clamp(speed, -3.0, 3.0) / kCount);
  }
  const auto check = [](const std::vector<double>& values) {
    const ChannelCheck channel[] = {{"motor_velocity_rad_s", values, 100.0}};
    return checkChannels("log.csv", channel);
  };
  EXPECT_THAT(check(steady), testing::IsEmpty());
  EXPECT_THAT(check(cut), ElementsAre(HasSubstr("looks clipped"), HasSubstr("looks clipped")));
}

TEST(ActuatorLog, APressureInBarUnderTheNameOfPascalsIsRefused) {
  const std::string rows = ",contraction,force_N\n0,0.1,1\n0.45,0.1,20\n";
  EXPECT_THAT(errorOf([&] { readPamLog(CsvTable::parse("pressure_Pa" + rows, "muscle.csv")); }),
              testing::AllOf(testing::HasSubstr("muscle.csv: pressure_Pa: found at most 0.45 Pa"),
                             testing::HasSubstr("--map pressure_Pa=COLUMN*1e5")));
  EXPECT_DOUBLE_EQ(readPamLog(CsvTable::parse("pressure_bar" + rows, "muscle.csv")).pressure[1], 45000.0);
}

}  // namespace
}  // namespace simgap::test
