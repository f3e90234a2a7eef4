// Rows that no reader could use: stamps out of order, cells without a number.
#include "simgap/measure/logs/log_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "simgap/core/error.h"

#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Rows "t,current,session,note" of a log with 40 rows, some of them replaced.
std::string log(const std::map<int, std::string>& other) {
  std::string text = "time_s,motor_current_A,session,note\n";
  for (int i = 0; i < 40; ++i) {
    const auto found = other.find(i);
    text += found == other.end() ? std::to_string(i) + ",1.5,a,x\n" : found->second + "\n";
  }
  return text;
}

LogTable readTable(const std::string& text) { return readLogTable(CsvTable::parse(text, "log.csv")); }

/// Rows `first` to `last` of a log that goes on for ever, with a rest from row 60 to 79, by a clock that begins at 0.
/// \param faster  than such a log
CsvTable recording(int first, int last, int faster = 0) {
  std::string text = "time_s,motor_current_A,motor_velocity_rad_s,session\n";
  for (int i = first; i <= last; ++i) {
    const bool rests = i >= 60 && i < 80;
    text += std::to_string(i - first) +
            (rests ? ",0,0," : "," + std::to_string(i * i % 97) + "," + std::to_string(i % 13 + faster) + ",") + "a\n";
  }
  return CsvTable::parse(text, "log.csv");
}

TEST(LogTable, RowsInBothAreThoseOfOneRecording) {
  EXPECT_EQ(rowsInBoth(recording(20, 49), recording(0, 99)), 30u) << "a piece of it";
  EXPECT_EQ(rowsInBoth(recording(30, 59), recording(0, 39)), 10u) << "one that goes on behind its end";
  EXPECT_EQ(rowsInBoth(recording(60, 79), recording(0, 99)), 0u) << "rests are alike";
  EXPECT_EQ(rowsInBoth(recording(200, 250), recording(0, 99)), 0u);
  EXPECT_EQ(rowsInBoth(recording(0, 50, 1), recording(0, 99)), 0u) << "one of two channels is another";
  const CsvTable others = CsvTable::parse("force_N\n1\n2\n", "other.csv");
  EXPECT_EQ(rowsInBoth(recording(0, 99), others), 0u) << "no channel in common";
}

TEST(LogTable, AGoodLogStaysAsItIs) {
  const LogTable found = readTable(log({}));
  EXPECT_EQ(found.table.rows(), 40u);
  EXPECT_TRUE(found.left_out.empty());
  EXPECT_TRUE(found.summary().empty());
}

TEST(LogTable, LeavesOutStampsThatRepeatOrGoBack) {
  const LogTable found = readTable(log({{5, "4,9,a,x"}, {12, "3,9,a,x"}}));
  ASSERT_EQ(found.left_out.size(), 1u);
  EXPECT_EQ(found.left_out[0].rows, 2u);
  EXPECT_EQ(found.table.rows(), 38u);
  EXPECT_EQ(found.left_out[0].last_row, 13u);
  EXPECT_EQ(found.table.lineOf(37), 41u);
  EXPECT_THAT(found.summary(), ElementsAre("log.csv: rows were left out: time repeats or goes back in 2 rows"));
}

TEST(LogTable, KeepsTheChosenSessionsAlone) {
  const CsvTable table = CsvTable::parse(log({{3, "3,2.5,b,x"}, {4, "4,2.5,b,x"}, {9, "9,none,c,x"}}), "log.csv");
  const LogTable found = readLogTable(table, {"b"});
  EXPECT_EQ(found.table.text("session"), (std::vector<std::string>{"b", "b"}));
  EXPECT_EQ(found.table.lineOf(0), 5u);
  EXPECT_EQ(readLogTable(table, {"a"}).left_out.size(), 0u);  // what c lacks is not asked for
  try {
    readLogTable(table, {"z"});
    FAIL() << "session z was taken";
  } catch (const DataError& error) {
    EXPECT_STREQ(error.what(), "log.csv: found no session z, expected one of a, b, c");
  }
}

TEST(LogTable, OneStampFarAheadCostsOneRow) {
  const LogTable found = readTable(log({{7, "1e9,9,a,x"}}));
  ASSERT_EQ(found.left_out.size(), 1u);
  EXPECT_EQ(found.left_out[0].first_row, 8u);
  EXPECT_EQ(found.table.rows(), 39u);
}

TEST(LogTable, TimeBeginsAnewWithASession) {
  std::map<int, std::string> second;
  for (int i = 20; i < 40; ++i) second[i] = std::to_string(i - 20) + ",1,b,x";
  EXPECT_EQ(readTable(log(second)).table.rows(), 40u);
  for (int i = 20; i < 40; ++i) second[i].replace(second[i].find('b'), 1, "a");
  EXPECT_THAT(errorOf([&] { readTable(log(second)); }),
              HasSubstr("log.csv:22: time goes from 19 s to 0 s, and 20 of 40 rows (50.0 %) repeat or go back"));
}

TEST(LogTable, RefusesAClockThatRunsBackwards) {
  EXPECT_THAT(errorOf([] { readTable("time_s,current_A\n3,1\n2,1\n1,1\n"); }),
              HasSubstr("log.csv:3: time goes from 3 s to 2 s, and 2 of 3 rows"));
}

TEST(LogTable, LeavesOutCellsWithoutANumberInItsChannels) {
  const LogTable found = readTable(log({{3, "3,nan,a,x"}, {9, "9,,a,x"}, {20, "20,off,a,"}}));
  ASSERT_EQ(found.left_out.size(), 1u);
  EXPECT_EQ(found.left_out[0].channel, "motor_current_A");
  EXPECT_EQ(found.left_out[0].rows, 3u);
  EXPECT_EQ(found.table.rows(), 37u);
  EXPECT_EQ(found.table.quantity("motor_current", "A").size(), 37u);
}

TEST(LogTable, RefusesAChannelThatLacksManyRows) {
  std::map<int, std::string> gaps;
  for (int i = 10; i < 15; ++i) gaps[i] = std::to_string(i) + ",,a,x";
  EXPECT_THAT(errorOf([&] { readTable(log(gaps)); }),
              HasSubstr("log.csv:12: found an empty cell, and 5 of 40 rows (12.5 %) have no number in motor_current_A, "
                        "expected at most 10 %"));
}

TEST(LogTable, ASparseTemperatureAndForeignColumnsCostNoRows) {
  std::string text = "time_s,current_A,temperature_degC,humidity\n";
  for (int i = 0; i < 40; ++i) text += std::to_string(i) + ",1," + (i % 10 == 0 ? "20.5,\n" : ",\n");
  EXPECT_EQ(readTable(text).table.rows(), 40u);
}

}  // namespace
}  // namespace simgap::test
