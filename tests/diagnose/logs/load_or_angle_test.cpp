// A pendulum's cable hangs straight where its weight does: friction by the bend and friction by the load say the same.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap {
namespace {

constexpr double kWeight = 0.5 * 9.81 * 0.2;  // [N m]

/// What diagnose says of a pendulum that swings by up to 1.4 rad times `swing`, and whose dry friction is that of `dry`
/// [N m] at an angle.
template <typename Dry>
Diagnosis diagnosePendulum(double swing, Dry dry) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::string csv = "time_s,motor_position_rad,motor_velocity_rad_s,motor_current_A\n";
  for (int i = 0; i < 9000; ++i) {
    const double t = 0.01 * i, theta = swing * (0.9 * std::sin(0.8 * t) + 0.5 * std::sin(0.31 * t + 1.0));
    const double w = swing * (0.72 * std::cos(0.8 * t) + 0.155 * std::cos(0.31 * t + 1.0));
    const double acceleration = -swing * (0.576 * std::sin(0.8 * t) + 0.04805 * std::sin(0.31 * t + 1.0));
    const double torque = kWeight * std::sin(theta) + 0.02 * acceleration + std::copysign(dry(theta), w) + 0.05 * w;
    csv += fmt::format("{:.3f},{:.4f},{:.5f},{:.5f}\n", t, theta, w, torque / 0.8 + noise(random));
  }
  PreparedLog log = prepareLog(
      CsvTable::parse(csv, "log.csv"),
      readBench(YamlNode::parse(
          "format: simgap/bench/1\nload: pendulum\nmass_kg: 0.5\nlength_m: 0.2\nangle_offset_rad: 0\n", "rig.yaml")),
      ActuatorKind::kFriction);
  return diagnoseLog(subjectOf("coulomb"), log, {}).diagnosis;
}

TEST(LoadOrAngle, ABendOfAnotherLawThanTheCataloguesIsNotCalledTheLoadAlone) {
  const Diagnosis found = diagnosePendulum(1.0, [](double theta) { return 0.06 + 0.12 * kWeight * std::abs(theta); });
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "load-dependence") << found.sentence;
  EXPECT_THAT(found.causes[0].ambiguous_with, testing::ElementsAre("bend-friction"));
}

/// Beyond a quarter turn the weight pulls less and the cable is bent more.
TEST(LoadOrAngle, TheLoadIsNamedAloneWhereItTellsClearlyMore) {
  const Diagnosis found =
      diagnosePendulum(1.7, [](double theta) { return 0.06 + 0.12 * kWeight * std::abs(std::sin(theta)); });
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "load-dependence") << found.sentence;
  EXPECT_THAT(found.causes[0].ambiguous_with, testing::IsEmpty());
}

}  // namespace
}  // namespace simgap
