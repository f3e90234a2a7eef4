// Degrees under names in radians.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/rotation.h"
#include "simgap/measure/logs/friction_rows.h"
#include "support/current_log.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

/// A drive that swings by 1 rad under a changing load; its columns times factors.
ActuatorLog swinging(double of_position, double of_velocity) {
  ActuatorLog log = test::currentLog("drive.csv");
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.01 * i;
    log.time.push_back(t);
    log.position.push_back(of_position * std::sin(2.0 * t));
    log.velocity.push_back(of_velocity * 2.0 * std::cos(2.0 * t));
    log.load.push_back(std::sin(0.7 * t));
    log.effort.push_back(log.load.back() + 0.2 * (std::cos(2.0 * t) > 0.0 ? 1.0 : -1.0));
    log.session.push_back(0);
  }
  log.session_names = {"all"};
  return log;
}

TEST(VelocityScale, DegreesBesideRadiansAreRefused) {
  EXPECT_THAT(errorOf([] { prepareFrictionData(swinging(1.0 / kDegree, 1.0), {}, {}); }),
              AllOf(HasSubstr("3: drive.csv: found a velocity that is 0.017"),
                    HasSubstr("a position in degrees has a column that ends in _deg)")));
  EXPECT_THAT(errorOf([] { prepareFrictionData(swinging(1.0, 1.0 / kDegree), {}, {}); }),
              AllOf(HasSubstr("found a velocity that is 57"), HasSubstr("ends in _deg_s)")));
}

TEST(VelocityScale, OneUnitAndAnotherShaftPass) {
  for (const double position : {1.0, 1.0 / 97.74}) {
    EXPECT_EQ(errorOf([&] { prepareFrictionData(swinging(position, 1.0), {}, {}); }), "no error");
  }
}

TEST(VelocityScale, APendulumThatTurnsRoundAndRoundIsAskedAbout) {
  Bench bench;
  bench.load = BenchLoad::kPendulum;
  bench.mass.value = bench.length.value = 1.0;
  ActuatorLog log = swinging(1.0 / kDegree, 1.0);
  log.velocity.clear();
  EXPECT_THAT(prepareFrictionData(log, bench, {}).warnings, Contains(HasSubstr("the pendulum turns 18 times round")));
}

}  // namespace
}  // namespace simgap::test
