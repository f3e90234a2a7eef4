// Tables of steady states, as a dynamometer gives them: no times, in any order, motion one way.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "fit/actuators/friction_gaps.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// Five speeds under nine loads each, without times. \param shuffled  in an order that says nothing
FrictionData dynamometer(bool shuffled) {
  std::vector<int> order(45);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(5);
  if (shuffled) std::ranges::shuffle(order, random);
  std::normal_distribution<double> noise(0.0, 0.2);
  std::string csv = "external_torque_Nm,motor_current_A,motor_velocity_rad_s\n";
  for (const int state : order) {
    const double speed = 10.0 * (1 + state / 9), load = 0.02 + 0.18 * (state % 9);
    const double current = (load + 0.0165 + 3e-4 * speed) / 0.0295 + noise(random);
    csv += fmt::format("{},{},{}\n", load, current, speed);
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

TEST(SteadyStates, OfRisingSpeedAllCount) {
  std::string csv = "motor_velocity_rad_s,motor_current_A,external_torque_Nm\n";
  for (const double speed : {63.0, 173.0, 291.0, 412.0, 590.0, 667.0}) {
    csv += fmt::format("{},{},0\n", speed, (0.0035 + 1e-5 * speed) / 0.027);
  }
  const FrictionData data = prepareFrictionData(readActuatorLog(CsvTable::parse(csv, "motor.csv"), {}), {}, {});
  EXPECT_EQ(data.rows(), 6U);
}

TEST(SteadyStates, WithTimesAreNoMotionWhereTheyJump) {
  std::string csv = "time_s,external_torque_Nm,motor_current_A,motor_velocity_rad_s\n";
  for (int row = 0; row < 40; ++row) csv += fmt::format("{},{},{},{}\n", 5 * row, 1 + row, 3 * row, row % 2 ? 60 : 1);
  EXPECT_THAT(errorOf([&] { prepareFrictionData(readActuatorLog(CsvTable::parse(csv, "dyno.csv"), {}), {}, {}); }),
              HasSubstr("dyno.csv: no row of 40 is left: the fastest moves at 60 rad_s"));
}

TEST(SteadyStates, OneWayAgainstOneLoadTheGainMayPassForFrictionByTheLoad) {
  const FrictionData data = dynamometer(false);
  const FrictionModel model(friction::find("classic"), data, {});
  std::vector<double> theta(model.parameters().size(), 1.0);
  theta[0] = 0.0295;
  EXPECT_EQ(degenerateFit(model, data, theta, false), "");
  theta[0] = 30.0;  // [N m/A] the load drives a thousandth of the current
  EXPECT_THAT(degenerateFit(model, data, theta, false), HasSubstr("k_a cannot be found with classic; record both"));
  FrictionData both = data;
  both.direction.head(20) *= -1.0;
  EXPECT_EQ(degenerateFit(model, both, theta, false), "") << "tells it from friction";
}

}  // namespace
}  // namespace simgap::test
