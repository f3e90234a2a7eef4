#include "diagnose/logs/held_out.h"

#include <gtest/gtest.h>

#include "simgap/core/error.h"
#include "support/files.h"

namespace simgap::test {
namespace {

PreparedLog withBlocks(std::size_t count) {
  PreparedLog log;
  log.file = "log.csv";
  for (std::size_t b = 0; b < count; ++b) log.blocks.push_back({100 * b, 100 * (b + 1)});
  log.data.keep.assign(100 * count, true);
  return log;
}

TEST(SplitLog, HoldsOutEveryFourthBlock) {
  const LogSplit split = splitLog(withBlocks(20), {});
  ASSERT_EQ(split.heldout.size(), 5u);
  EXPECT_EQ(split.training.size(), 15u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(split.heldout[k].begin, 100 * (4 * k + 2));
}

// A drive that stood wherever rows were held out was judged by an error that is no number.
TEST(SplitLog, HoldsOutMotion) {
  PreparedLog log = withBlocks(20);
  for (std::size_t b = 2; b < 20; b += 4)
    std::fill_n(log.data.keep.begin() + static_cast<std::ptrdiff_t>(100 * b), 100, false);
  const LogSplit split = splitLog(log, {});
  EXPECT_EQ(split.training.size() + split.heldout.size(), 15u);
  ASSERT_EQ(split.heldout.size(), 4u);
  EXPECT_EQ(split.heldout[0].begin, 300u);
  log.data.keep.assign(2000, false);
  EXPECT_NE(errorOf([&] { splitLog(log, {}); }).find("found 0 blocks to learn from"), std::string::npos);
}

TEST(SplitLog, ObeysAMaskOfRows) {
  LogDiagnosisOptions options;
  options.heldout_rows.assign(1000, false);
  std::fill(options.heldout_rows.begin() + 300, options.heldout_rows.begin() + 500, true);
  const LogSplit split = splitLog(withBlocks(10), options);
  ASSERT_EQ(split.heldout.size(), 2u);
  EXPECT_EQ(split.heldout[0].begin, 300u);
  EXPECT_EQ(split.heldout[1].begin, 400u);
}

TEST(OtherSplits, HoldOutWhatTheFirstDoesNot) {
  const std::vector<LogSplit> splits = otherSplits(withBlocks(20), {});
  ASSERT_EQ(splits.size(), 3u);
  const std::size_t first[] = {3, 0, 1};
  for (std::size_t s = 0; s < 3; ++s) {
    ASSERT_EQ(splits[s].heldout.size(), 5u);
    EXPECT_EQ(splits[s].training.size(), 15u);
    EXPECT_EQ(splits[s].heldout[0].begin, 100 * first[s]);
  }
}

TEST(OtherSplits, AreNoneWhereFiftyBlocksAreHeldOut) {
  EXPECT_EQ(otherSplits(withBlocks(199), {}).size(), 3u);
  EXPECT_TRUE(otherSplits(withBlocks(200), {}).empty());
}

TEST(OtherSplits, AreNoneWhereRowsWereGiven) {
  LogDiagnosisOptions options;
  options.heldout_rows.assign(1000, false);
  EXPECT_TRUE(otherSplits(withBlocks(10), options).empty());
}

TEST(SplitLog, RefusesLogsTooShortToLearnFrom) {
  EXPECT_NE(errorOf([] { splitLog(withBlocks(5), {}); }).find("found 4 blocks to learn from and 1"), std::string::npos);
  LogDiagnosisOptions none;
  none.heldout_rows.assign(1000, false);
  EXPECT_THROW(splitLog(withBlocks(10), none), DataError);
}

}  // namespace
}  // namespace simgap::test
