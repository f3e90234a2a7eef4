// Tables of steady states, as a dynamometer gives them: no times, in any order, motion one way.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "simgap/fit/actuators/friction_fit.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// Five speeds under nine loads each. \param shuffled  in an order that says nothing \param row_s  from row to row, in
/// a column time_s; 0: without
FrictionData dynamometer(bool shuffled, double row_s = 0.0) {
  std::vector<int> order(45);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(5);
  if (shuffled) std::ranges::shuffle(order, random);
  std::normal_distribution<double> noise(0.0, 0.2);
  std::string csv = "external_torque_Nm,motor_current_A,motor_velocity_rad_s";
  csv += row_s > 0.0 ? ",time_s\n" : "\n";
  for (std::size_t row = 0; row < order.size(); ++row) {
    const double speed = 10.0 * (1 + order[row] / 9), load = 0.02 + 0.18 * (order[row] % 9);
    const double current = (load + 0.0165 + 3e-4 * speed) / 0.0295 + noise(random);
    csv += fmt::format("{},{},{}", load, current, speed);
    csv += row_s > 0.0 ? fmt::format(",{}\n", row_s * static_cast<double>(row)) : "\n";
  }
  return prepareFrictionData(readActuatorLog(CsvTable::parse(csv, "dyno.csv"), {}), {}, {});
}

TEST(SteadyStates, InAnyOrderHaveOneAnswer) {
  for (const bool shuffled : {false, true}) {
    const FrictionData data = dynamometer(shuffled);
    EXPECT_EQ(data.rows(), 45U) << shuffled;
    const FrictionFit found = fitFriction(friction::find("coulomb"), data, {});
    EXPECT_NEAR(found.value("k_a"), 0.0295, 0.0005) << shuffled;
    EXPECT_THAT(found.warnings, Not(Contains(HasSubstr("acceleration")))) << shuffled;
  }
}

TEST(SteadyStates, WithTimesAreNoMotionWhereTheyJump) {
  EXPECT_THAT(errorOf([] { dynamometer(true, 5.0); }), HasSubstr("dyno.csv: no row of 45 is left: the fastest moves"));
}

TEST(SteadyStates, OneWayAgainstOneLoadDoNotTellTheGainFromFrictionByTheLoad) {
  EXPECT_THAT(errorOf([] { fitFriction(friction::find("classic"), dynamometer(false), {}); }),
              HasSubstr("k_a cannot be found with classic; record both directions"));
}

}  // namespace
}  // namespace simgap::test
