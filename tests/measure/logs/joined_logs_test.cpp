// Logs recorded one after another read as one, with their rows' sessions told apart.
#include "simgap/measure/logs/joined_logs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

LogTable logOf(const std::string& text, const std::string& name) { return readLogTable(CsvTable::parse(text, name)); }

TEST(JoinedLogs, AreSessionsOfTheColumnsThatAllHave) {
  const LogTable all = joinedLogs({logOf("time_s,motor_current_A,note\n0,-1.5,a\n1,2,b\n", "runs/before.csv"),
                                   logOf("motor_current_A,time_s,lamp\n3,0,1\n", "runs/after.csv")});
  EXPECT_THAT(all.table.columns(), ElementsAre("time_s", "motor_current_A", "session"));
  EXPECT_THAT(all.table.quantity("motor_current", "A"), ElementsAre(-1.5, 2.0, 3.0));
  EXPECT_THAT(all.table.text("session"), ElementsAre("1-before", "1-before", "2-after"));
}

TEST(JoinedLogs, KeepTheirOwnSessionsAndWhatWasLeftOut) {
  const LogTable all =
      joinedLogs({logOf("time_s,current_A,session\n0,1,7\n0,2,8\n", "a.csv"),
                  logOf("time_s,current_A,session\n0,1,7\n1,2,7\n1,3,7\n2,1,7\n3,1,7\n4,1,7\n5,1,7\n6,1,"
                        "7\n7,1,7\n8,1,7\n9,1,7\n",
                        "a.csv")});
  EXPECT_EQ(all.table.rows(), 12u);
  EXPECT_THAT(all.table.text("session"), testing::IsSupersetOf({"1-a-7", "1-a-8", "2-a-7"}));
  ASSERT_EQ(all.left_out.size(), 1u);
  EXPECT_THAT(all.left_out[0].sentence, testing::StartsWith("a.csv: time repeats or goes back"));
}

TEST(JoinedLogs, OneAloneStaysAsItIs) {
  const LogTable one = joinedLogs({logOf("time_s,current_A,note\n0,1,x\n1,2,y\n", "a.csv")});
  EXPECT_THAT(one.table.columns(), ElementsAre("time_s", "current_A", "note"));
}

TEST(JoinedLogs, AChannelThatOneLacksIsRefused) {
  EXPECT_EQ(errorOf([] {
              joinedLogs({logOf("time_s,current_A,voltage_V\n0,1,2\n1,1,2\n", "a.csv"),
                          logOf("time_s,current_A\n0,1\n1,1\n", "b.csv")});
            }),
            "3: b.csv: found no whole column voltage_V, which a.csv has; expected the same channels in every log");
  EXPECT_EQ(
      errorOf([] {
        joinedLogs({logOf("time_s,current_A\n0,1\n1,1\n", "a.csv"),
                    logOf("time_s,current_A,temperature_degC\n0,1,20\n1,1,21\n", "b.csv")});
      }),
      "3: a.csv: found no whole column temperature_degC, which b.csv has; expected the same channels in every log");
}

}  // namespace
}  // namespace simgap::test
