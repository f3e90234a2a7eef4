// A weight beside the one a pendulum's bench knows: what pulls with the known one, k_a makes up for, and what pulls
// across it is named.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap {
namespace {

using testing::ElementsAre;

constexpr double kBob = 0.5 * 9.81 * 0.2, kBobInertia = 0.5 * 0.2 * 0.2;  // of the known bob [N m], [kg m2]

/// Swings, and a bracket of `bracket` N m hangs `angle` rad from the bob. \returns what diagnose says of it
Diagnosis diagnoseBracket(double bracket, double angle) {
  constexpr double kRate = 100.0, kGain = 0.8;  // [Hz], [N m / A]
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::string csv = "time_s,motor_position_rad,motor_velocity_rad_s,motor_current_A\n";
  for (int i = 0; i < 9000; ++i) {
    const double t = i / kRate, theta = 0.2 + 0.9 * std::sin(0.8 * t) + 0.5 * std::sin(0.31 * t + 1.0);
    const double w = 0.72 * std::cos(0.8 * t) + 0.155 * std::cos(0.31 * t + 1.0);
    const double acceleration = -0.576 * std::sin(0.8 * t) - 0.04805 * std::sin(0.31 * t + 1.0);
    const double weights = kBob * std::sin(theta) + bracket * std::sin(theta - angle);
    const double torque = weights + kBobInertia * acceleration + (w > 0.0 ? 0.12 : -0.12) + 0.05 * w;
    csv += fmt::format("{:.3f},{:.4f},{:.5f},{:.5f}\n", t, theta, w, torque / kGain + 0.01 * noise(random));
  }
  PreparedLog log = prepareLog(
      CsvTable::parse(csv, "log.csv"),
      readBench(YamlNode::parse(
          "format: simgap/bench/1\nload: pendulum\nmass_kg: 0.5\nlength_m: 0.2\nangle_offset_rad: 0\n", "rig.yaml")),
      ActuatorKind::kFriction);
  return diagnoseLog(subjectOf("coulomb"), log, {}).diagnosis;
}

TEST(JointGravity, OfABracketBesideAPendulumsBobIsWhatPullsAcross) {
  const Diagnosis found = diagnoseBracket(0.2, 1.2);
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "joint-gravity") << found.sentence;
  EXPECT_EQ(found.causes[0].form, "across");
  EXPECT_THAT(found.causes[0].ambiguous_with, ElementsAre());
  // k_a takes what pulls along: everything is seen in units of 1 + b cos(angle) / M.
  const double along = 1.0 + 0.2 * std::cos(1.2) / kBob;
  ASSERT_FALSE(found.causes[0].parameters.empty());
  EXPECT_EQ(found.causes[0].parameters[0].name, "mgl_across");
  EXPECT_NEAR(found.causes[0].parameters[0].value, -0.2 * std::sin(1.2) / along,
              4.0 * found.causes[0].parameters[0].sd + 0.002);
}

TEST(JointGravity, OfABracketThatHangsWithTheBobIsItsMass) {
  EXPECT_THAT(diagnoseBracket(0.2, 0.0).causes, ElementsAre()) << "k_a makes up for it";
}

}  // namespace
}  // namespace simgap
