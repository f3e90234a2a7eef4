#include "simgap/fit/actuators/requirements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "support/files.h"

namespace simgap {
namespace {

using ::testing::HasSubstr;

TEST(Requirements, ReadsWorkingPointsAndThoseOfThePaper) {
  const std::vector<Requirement> all = readRequirements({"lift:180:12.5", "paper"});
  ASSERT_EQ(all.size(), 1u + paperRequirements().size());
  EXPECT_EQ(all[0].name, "lift");
  EXPECT_DOUBLE_EQ(all[0].velocity, std::numbers::pi);
  EXPECT_EQ(all[0].torque, 12.5);
  EXPECT_DOUBLE_EQ(all.back().velocity, 91.0 * std::numbers::pi / 180.0);
  EXPECT_EQ(all.back().torque, 20.0);
}

TEST(Requirements, SaysWhatItCannotRead) {
  for (const char* text : {"lift", "lift:90", "lift:fast:20", "lift:90:", "lift:-1:5", "lift:90:0", ":90:5"}) {
    EXPECT_THAT(test::errorOf([&] { readRequirements({text}); }),
                HasSubstr(std::string("2: --require: found '") + text + "', expected NAME:DEG_PER_S:NM"));
  }
}

TEST(Requirements, TheFurthestPointCoversWhatIsNearerInBoth) {
  const Eigen::ArrayXd velocity = Eigen::ArrayXd::LinSpaced(5, -20.0, 10.0);
  const Eigen::ArrayXd load = Eigen::ArrayXd::LinSpaced(5, -3.0, 7.0);
  const auto covers = [&](const Requirement& r) { return coveredRange(r, velocity, load, {}, 10.0).covers(r); };
  EXPECT_TRUE(covers({"both at the edge", 2.0, 7.0}));
  EXPECT_FALSE(covers({"too fast", 2.1, 1.0}));
  EXPECT_FALSE(covers({"too heavy", 1.0, 7.1}));
}

TEST(Requirements, CountsTheCellsWithRows) {
  // Rows only where velocity and load are positive: a quarter of the cells, at half of the angles.
  constexpr int kRows = 10000;
  Eigen::ArrayXd velocity(kRows), load(kRows), angle(kRows);
  for (int i = 0; i < kRows; ++i) {
    velocity[i] = 10.0 * 0.01 * (0.5 + i % 100);
    load[i] = 5.0 * 0.01 * (0.5 + (i / 100) % 100);
    angle[i] = 10.0 * (i % 100) / 100.0;
  }
  const Requirement quarter{"quarter", 1.0, 5.0, std::pair(-1.0, 1.0)};
  const CoveredRange covered = coveredRange(quarter, velocity, load, angle, 10.0);
  EXPECT_DOUBLE_EQ(covered.cells, 0.25);
  EXPECT_DOUBLE_EQ(*covered.angle, 0.5);
  EXPECT_FALSE(coveredRange(quarter, velocity, load, {}, 10.0).angle) << "without positions nothing is said of them";
  // Nine rows in a cell are not enough.
  EXPECT_DOUBLE_EQ(coveredRange(quarter, velocity.head(9), load.head(9), {}, 10.0).cells, 0.0);
}

TEST(Requirements, HistogramsCountEveryRowOnce) {
  const Eigen::ArrayXd values = Eigen::ArrayXd::LinSpaced(101, -1.0, 3.0);
  const Histogram histogram = histogramOf(values, 4);
  EXPECT_EQ(histogram.edges, (std::vector<double>{-1.0, 0.0, 1.0, 2.0, 3.0}));
  EXPECT_EQ(histogram.rows, (std::vector<std::size_t>{25, 25, 25, 26}));
}

}  // namespace
}  // namespace simgap
