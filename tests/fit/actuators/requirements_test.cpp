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
  for (const char* text : {"lift", "lift:90", "lift:fast:20", "lift:90:"}) {
    EXPECT_THAT(test::errorOf([&] { readRequirements({text}); }),
                HasSubstr(std::string("2: --require: found '") + text + "', expected NAME:DEG_PER_S:NM"));
  }
}

TEST(Requirements, TheFurthestPointCoversWhatIsNearerInBoth) {
  const Eigen::ArrayXd velocity = Eigen::ArrayXd::LinSpaced(5, -20.0, 10.0);
  const Eigen::ArrayXd load = Eigen::ArrayXd::LinSpaced(5, -3.0, 7.0);
  const WorkingPoint reached = furthestPoint(velocity, load, 10.0);
  EXPECT_EQ(reached.velocity, 2.0);  // at the joint
  EXPECT_EQ(reached.load, 7.0);
  EXPECT_TRUE(reached.covers({"both at the edge", 2.0, 7.0}));
  EXPECT_FALSE(reached.covers({"too fast", 2.1, 1.0}));
  EXPECT_FALSE(reached.covers({"too heavy", 1.0, 7.1}));
}

}  // namespace
}  // namespace simgap
