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

/// Least squares raise k_a by the noise's share of the load's variance; of white noise a part within the bandwidth
/// stays.
TEST(LoadNoise, HardlyRaisesTheTorqueConstant) {
  const reality::FrictionTruth truth = noisySensor(kSensorNoise);
  const reality::FrictionLog log = reality::simulateFrictionLog(truth, {.rows = 20000});
  FrictionDataOptions as_measured;
  as_measured.load_is_fitted = true;
  const double too_large = torqueConstant(frictionData(log, as_measured)) - truth.torque_per_ampere;
  ASSERT_GT(too_large, 0.1 * truth.torque_per_ampere) << "noise that does no harm tests nothing";
  const FrictionData data = frictionData(log);
  EXPECT_THAT(data.warnings, Contains(HasSubstr("external_torque is noisy")));
  EXPECT_NEAR(torqueConstant(data), truth.torque_per_ampere, 0.25 * too_large);
}

/// A sensor on which nothing acts.
TEST(LoadNoise, AloneIsNoLoad) {
  reality::FrictionLog log = reality::simulateFrictionLog(noisySensor(0.0), {.rows = 5000});
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, kSensorNoise);
  for (double& load : log.load) load = noise(random);
  EXPECT_THAT(frictionData(log).warnings, Not(Contains(HasSubstr("noisy"))));
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
