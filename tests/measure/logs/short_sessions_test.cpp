// A recorder that stops just after it began leaves a session of two rows: no slope, and no reason to refuse the others.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap::test {
namespace {

/// Sessions of a joint that swings, each with so many rows.
PreparedLog sessionsOf(const std::vector<int>& lengths) {
  std::string csv = "time_s,session,motor_position_rad,external_torque_Nm,motor_current_A\n";
  int row = 0;
  for (std::size_t session = 0; session < lengths.size(); ++session) {
    for (int i = 0; i < lengths[session]; ++i, ++row) {
      const double t = 0.01 * row, angle = 3.0 * std::sin(1.3 * t), load = std::sin(0.4 * t);
      csv += fmt::format("{:.2f},{},{:.6f},{:.6f},{:.6f}\n", t, session, angle, load,
                         load + 0.2 * std::copysign(1.0, std::cos(1.3 * t)));
    }
  }
  return prepareLog(CsvTable::parse(csv, "log.csv"), {}, ActuatorKind::kFriction);
}

TEST(ShortSessions, AreLeftOutAndCounted) {
  const PreparedLog log = sessionsOf({1500, 2, 1500});
  ASSERT_EQ(log.data.keep.size(), 3002u);
  EXPECT_FALSE(log.data.keep[1500] || log.data.keep[1501]);
  EXPECT_GT(std::ranges::count(log.data.keep, true), 2500);
  const auto says = [](const std::string& w) { return w.find("2 rows are of sessions") != std::string::npos; };
  EXPECT_TRUE(std::ranges::any_of(log.warnings, says));
}

TEST(ShortSessions, LeaveTheOthersAsTheyAre) {
  const PreparedLog alone = sessionsOf({1500}), beside = sessionsOf({1500, 3});
  EXPECT_TRUE((alone.data.rows.speed == beside.data.rows.speed.head(1500)).all());
}

TEST(ShortSessions, AloneAreRefused) {
  try {
    sessionsOf({3, 2, 3});
    FAIL() << "expected a DataError";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("log.csv: found no session of 4 rows"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace simgap::test
