#include "diagnose/logs/few_rows.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "prepared_logs.h"

namespace simgap::test {
namespace {

TEST(FewRows, AreSpreadOverTheRowsThatCountInTheBlocks) {
  PreparedLog log = preparedLog(smallRig(3000));
  for (std::size_t i = 1000; i < 1300; ++i) log.data.keep[i] = false;
  const FewRows few = fewRowsOf(log.data, {{500, 1500}, {2000, 3000}}, 300);
  ASSERT_EQ(few.at.size(), 300u);
  EXPECT_TRUE(std::ranges::is_sorted(few.at, std::less_equal<>{}));  // each once
  for (const Eigen::Index i : few.at) {
    EXPECT_TRUE(log.data.keep[static_cast<std::size_t>(i)]);
    EXPECT_TRUE((i >= 500 && i < 1500) || (i >= 2000 && i < 3000)) << i;
  }
  const auto first = std::ranges::count_if(few.at, [](Eigen::Index i) { return i < 1500; });
  EXPECT_NEAR(static_cast<double>(first), 300.0 * 700.0 / 1700.0, 15.0);
  ASSERT_EQ(few.blocks.size(), 1u);
  EXPECT_EQ(few.blocks[0].size(), 300u);
}

TEST(FewRows, AreAllThatCountWhereThoseAreNotTwiceAsMany) {
  const PreparedLog log = preparedLog(smallRig(3000));
  const auto counted = static_cast<std::size_t>(std::ranges::count(log.data.keep, true));
  EXPECT_EQ(fewRowsOf(log.data, {{0, 3000}}, counted / 2 + 1).at.size(), counted);
}

TEST(FewRows, TravelIsSinceTheOneBeforeOrTheTurnBetweenThem) {
  const PreparedLog log = preparedLog(smallRig(3000));
  const ActuatorRows& rows = log.data.rows;
  const FewRows few = fewRowsOf(log.data, {{0, 3000}}, 200);
  int turned = 0;
  for (std::size_t k = 1; k < few.at.size(); ++k) {
    Eigen::Index from = few.at[k];
    while (from > few.at[k - 1] + 1 && rows.direction[from] == rows.direction[from - 1]) --from;
    if (rows.direction[from] != rows.direction[few.at[k - 1]]) ++turned;
    const double way = rows.travel.segment(from, few.at[k] - from + 1).sum();
    EXPECT_NEAR(few.data.rows.travel[static_cast<Eigen::Index>(k)], way, 1e-12 * (1.0 + way));
  }
  EXPECT_GT(turned, 5);
}

}  // namespace
}  // namespace simgap::test
