// What slow motion's friction looks like is no evidence for a cause that acts in fast motion.
#include "diagnose/logs/slow_friction.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnose/logs/held_out.h"

namespace simgap {
namespace {

/// A drive that moves slowly, fast, slowly … against a known torque. \param damping  of its bristles, which die out
/// with speed; \param exponent  of its viscous friction.
PreparedLog slowAndFast(double damping, double exponent, double effort_noise = 0.03) {
  constexpr int kRows = 5000;
  constexpr double kRate = 50.0;
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::string csv = "time_s,motor_velocity_rad_s,external_torque_Nm,motor_current_A\n";
  for (int i = 0; i < kRows; ++i) {
    const double t = i / kRate, size = 0.06 + 0.94 * std::pow(std::sin(0.11 * t), 4);
    const double w = size * (std::sin(2.1 * t) + 0.6 * std::sin(3.7 * t + 1.0));
    const double load = 0.5 * std::sin(0.9 * t), slow = std::abs(w) / 0.05, way = w > 0.0 ? 1.0 : -1.0;
    const double dry = 0.7 + 0.35 / (1.0 + slow * slow) + damping * slow * std::exp(-slow);
    const double viscous = 0.6 * std::pow(std::abs(w), exponent);
    const double effort = load + way * (dry + viscous) + effort_noise * noise(random);
    csv += fmt::format("{:.2f},{:.6f},{:.6f},{:.6f}\n", t, w + 2e-4 * noise(random), load, effort);
  }
  return prepareLog(CsvTable::parse(csv, "log.csv"), {}, ActuatorKind::kFriction);
}

/// Shares of the squared error that a nonlinear viscous friction explains.
struct Gains {
  double alone, beside;  ///< of the law, beside any friction in slow motion
  double below;          ///< [rad/s] what counts as slow
};

Gains gainsOf(const PreparedLog& log) {
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("stribeck"), log.data, splitLog(log, options).training, options);
  Fitted rest = search.fit({}, nullptr);
  search.validate(rest);
  const Fitted full = search.tryAll(rest, {{&actuator_effects::find("viscous-nonlinearity"), {}, {}}})[0].fitted;
  const auto slow = besideSlowFriction(search, rest, full, false);
  return {1.0 - full.mse / rest.mse, 1.0 - slow->full.mse / slow->rest.mse, slow->below};
}

TEST(FrictionInSlowMotion, BristlesThatDampTheirMotionAreNoViscousNonlinearity) {
  const Gains gains = gainsOf(slowAndFast(0.8, 1.0, 0.06));
  EXPECT_GT(gains.alone, 2.0 * LogDiagnosisOptions().least_gain);  // it fits better: that is the trap
  EXPECT_LT(gains.beside, LogDiagnosisOptions().least_gain);
}

TEST(FrictionInSlowMotion, DragThatGrowsWithTheSquareIsSeenBesideIt) {
  for (const double damping : {0.0, 0.8}) {
    const Gains gains = gainsOf(slowAndFast(damping, 2.0));
    EXPECT_GT(gains.alone, 0.15) << damping;
    EXPECT_GT(gains.beside, 2.0 * LogDiagnosisOptions().least_gain) << damping;
  }
}

TEST(FrictionInSlowMotion, IsNoMoreThanAQuarterOfTheFastMotion) {
  const Gains gains = gainsOf(slowAndFast(0.0, 1.0));
  EXPECT_GT(gains.below, 0.05);
  EXPECT_LT(gains.below, 0.4);
}

TEST(FrictionInSlowMotion, StandsBesideLawsWithoutACurveToo) {
  const PreparedLog log = slowAndFast(0.0, 1.0);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("coulomb"), log.data, splitLog(log, options).training, options);
  const Fitted plain = search.fit({}, nullptr);
  const auto slow = besideSlowFriction(search, plain, plain, false);
  ASSERT_TRUE(slow);
  EXPECT_LT(slow->full.mse, plain.mse);
}

}  // namespace
}  // namespace simgap
