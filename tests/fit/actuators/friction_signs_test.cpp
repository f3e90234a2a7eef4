#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reality/friction_log.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/friction_comparison.h"

namespace simgap::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

reality::FrictionLog sample() {
  reality::FrictionTruth truth;
  truth.sliding_offset = 1.0;
  return simulateFrictionLog(truth, {});
}

FrictionComparison fitLog(const reality::FrictionLog& log, const FrictionFitOptions& options = {}) {
  const FrictionData data = prepareFrictionData(readActuatorLog(CsvTable::parse(log.csv(), "drive.csv"), {}), {}, {});
  const std::vector<std::string> laws = {"all"};
  return compareLaws(lawsNamed(laws), data, options, nullptr, "");
}

/// The sentence of the refusal; empty when the fit delivers.
std::string refusal(const reality::FrictionLog& log, const FrictionFitOptions& options = {}) {
  try {
    fitLog(log, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kNumerics);
    return error.what();
  }
  return {};
}

void turn(std::vector<double>& channel) {
  for (double& value : channel) value = -value;
}

TEST(FrictionSigns, TheTurnedChannelIsNamedWithTheFlagThatHelps) {
  reality::FrictionLog current = sample(), load = sample(), velocity = sample();
  turn(current.current), turn(load.load), turn(velocity.velocity);
  EXPECT_THAT(refusal(current),
              AllOf(HasSubstr("motor_current_A has the opposite sign"), HasSubstr("--map motor_current_A=COLUMN*-1")));
  EXPECT_THAT(refusal(load), AllOf(HasSubstr("external_torque_Nm has the opposite sign"),
                                   HasSubstr("--map external_torque_Nm=COLUMN*-1")));
  EXPECT_THAT(refusal(velocity), AllOf(HasSubstr("motor_velocity_rad_s has the opposite sign"),
                                       HasSubstr("--map motor_velocity_rad_s=COLUMN*-1")));
}

TEST(FrictionSigns, AlsoWhereTheTorqueIsPredicted) {
  reality::FrictionLog log = sample();
  turn(log.current);
  FrictionFitOptions options;
  options.predict_load = true;
  EXPECT_THAT(refusal(log, options), HasSubstr("motor_current_A has the opposite sign"));
}

TEST(FrictionSigns, AnEffortThatKnowsNothingOfTheLoadIsRefused) {
  reality::FrictionLog log = sample();
  for (std::size_t i = 0; i < log.current.size(); ++i)
    log.current[i] = -1e-3 * log.load[i] + 0.5 * std::sin(37.0 * static_cast<double>(i));
  EXPECT_THAT(refusal(log), HasSubstr("k_a cannot be found"));
}

/// A propeller's bus current goes with power: it grows ever faster with speed, and all motion is forwards.
TEST(FrictionSigns, ACurveOverOneDirectionIsNoTurnedVelocity) {
  reality::FrictionLog log = sample();
  for (std::size_t i = 0; i < log.current.size(); ++i) {
    const double w = std::abs(log.velocity[i]);
    log.velocity[i] = w;
    log.load[i] = 2e-4 * w * w;
    log.current[i] = 1e-6 * w * w * w + 0.01 * std::sin(37.0 * static_cast<double>(i));
  }
  EXPECT_THAT(refusal(log), Not(HasSubstr("velocity_rad_s has the opposite sign")));
}

TEST(FrictionSigns, RightSignsGiveBoundedParameters) {
  const FrictionComparison comparison = fitLog(sample());
  EXPECT_TRUE(comparison.left_out.empty());
  for (const FrictionFit& fit : comparison.fits) {
    for (const Estimate& e : fit.uncertainty.estimates)
      EXPECT_LT(std::abs(e.value), 1e3) << fit.law->name << " " << e.name;
  }
}

}  // namespace
}  // namespace simgap::test
