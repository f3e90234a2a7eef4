// Noise of the torque sensor, which a fit of the current would take for load.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "simgap/fit/actuators/friction_fit.h"
#include "support/friction_logs.h"

namespace simgap::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kSensorNoise = 2.0;  // [N m]

reality::FrictionTruth noisySensor(double noise) {
  reality::FrictionTruth truth;
  truth.load_noise = noise;
  return truth;
}

double torqueConstant(const FrictionData& data) {
  return fitFriction(friction::find("variant-a"), data, {}).value("k_a");
}

TEST(LoadNoise, DoesNotRaiseTheTorqueConstant) {
  const reality::FrictionTruth truth = noisySensor(kSensorNoise);
  const reality::FrictionLog log = reality::simulateFrictionLog(truth, {.rows = 20000});
  const FrictionData data = frictionData(log);
  EXPECT_THAT(data.warnings, Contains(HasSubstr("external_torque is noisy (sd 2")));
  EXPECT_NEAR(torqueConstant(data), truth.torque_per_ampere, 0.01 * truth.torque_per_ampere);
  FrictionDataOptions as_measured;
  as_measured.load_is_fitted = true;
  EXPECT_GT(torqueConstant(frictionData(log, as_measured)), 1.03 * truth.torque_per_ampere)
      << "noise that does no harm tests nothing";
}

TEST(LoadNoise, OfAGoodSensorStays) {
  const reality::FrictionLog log = reality::simulateFrictionLog(noisySensor(0.03), {.rows = 5000});
  const FrictionData data = frictionData(log);
  EXPECT_THAT(data.warnings, Not(Contains(HasSubstr("noisy"))));
  EXPECT_EQ(data.load[1000], log.load[data.row[1000]]);
}

/// A drive that is shaken draws what shakes it: that is load.
TEST(LoadNoise, ThatTheEffortAnswersToIsLoad) {
  reality::FrictionLog log = reality::simulateFrictionLog(noisySensor(0.0), {.rows = 5000});
  std::mt19937_64 random(7);
  std::normal_distribution<double> shaken(0.0, kSensorNoise);
  for (std::size_t i = 0; i < log.load.size(); ++i) {
    const double more = shaken(random);
    log.load[i] += more;
    log.current[i] += more / reality::FrictionTruth().torque_per_ampere;
  }
  EXPECT_THAT(frictionData(log).warnings, Not(Contains(HasSubstr("noisy"))));
}

}  // namespace
}  // namespace simgap::test
