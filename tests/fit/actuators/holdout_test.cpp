#include "simgap/fit/actuators/holdout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "simgap/core/error.h"

namespace simgap {
namespace {

CsvTable table() { return CsvTable::parse("session,load\n1,none\n2,none\n3,heavy\n3,none\n", "log.csv"); }

TEST(HoldoutTest, NamesRowsByTheValuesOfAColumn) {
  EXPECT_THAT(readHoldout("session=1,3", table()).rows, testing::ElementsAre(true, false, true, true));
  const Holdout heavy = readHoldout("load=heavy", table());
  EXPECT_THAT(heavy.rows, testing::ElementsAre(false, false, true, false));
  EXPECT_EQ(heavy.words, "load=heavy");
  EXPECT_FALSE(readHoldout("", table()).any());
}

TEST(HoldoutTest, RefusesWhatNoRowHasAndWhatIsNeitherFractionNorColumn) {
  EXPECT_THROW(readHoldout("session=3,9", table()), DataError);
  EXPECT_THROW(readHoldout("session", table()), ConfigError);
  for (const char* fraction : {"0", "1", "-0.2"}) EXPECT_THROW(readHoldout(fraction, table()), ConfigError) << fraction;
}

TEST(HoldoutTest, AFractionIsSpreadEvenlyOverWholeBlocks) {
  std::vector<Block> blocks;
  for (std::size_t b = 0; b < 10; ++b) blocks.push_back({10 * b, 10 * b + 10});
  const std::vector<bool> fitted = fittedRows(readHoldout("0.2", table()), blocks);
  ASSERT_EQ(fitted.size(), 100u);
  std::vector<std::size_t> out;
  for (std::size_t b = 0; b < 10; ++b) {
    const auto count = std::count(fitted.begin() + static_cast<std::ptrdiff_t>(10 * b),
                                  fitted.begin() + static_cast<std::ptrdiff_t>(10 * b + 10), false);
    ASSERT_TRUE(count == 0 || count == 10) << "block " << b << " is torn: " << count;
    if (count == 10) out.push_back(b);
  }
  EXPECT_THAT(out, testing::ElementsAre(2, 7));
}

TEST(HoldoutTest, SomeRowsMustStayOnEachSide) {
  const std::vector<Block> one{{0, 4}};
  EXPECT_THROW(fittedRows(readHoldout("0.2", table()), one), DataError);
  EXPECT_THROW(fittedRows(readHoldout("session=1,2,3", table()), one), DataError);
}

TEST(HoldoutTest, BlocksAreTwentySecondsOrATenthOfAShortLog) {
  EXPECT_EQ(blockSeconds({}, 1000.0), 20.0);
  EXPECT_EQ(blockSeconds({}, 50.0), 5.0);
  EXPECT_EQ(blockSeconds({}, 0.0), 20.0);  // a log without times
  EXPECT_EQ(blockSeconds(3.0, 50.0), 3.0);
}

TEST(HoldoutTest, AFifthJudgesBeforeTheFinalFitWhereThereAreBlocks) {
  std::vector<Block> blocks;
  for (std::size_t b = 0; b < 5; ++b) blocks.push_back({10 * b, 10 * b + 10});
  const JudgedRows judged = judgedRows({}, blocks);
  EXPECT_EQ(std::ranges::count(judged.fitted, false), 10);
  EXPECT_TRUE(judged.then_all);
  blocks.pop_back();
  EXPECT_EQ(std::ranges::count(judgedRows({}, blocks).fitted, false), 0);  // too few: all are fitted
  const JudgedRows named = judgedRows(readHoldout("session=3", table()), std::vector<Block>{{0, 2}, {2, 4}});
  EXPECT_THAT(named.fitted, testing::ElementsAre(true, true, false, false));
  EXPECT_FALSE(named.then_all);
  EXPECT_EQ(named.words, "session=3");
}

}  // namespace
}  // namespace simgap
