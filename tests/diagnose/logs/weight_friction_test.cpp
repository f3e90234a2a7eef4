// Friction that grows with a pendulum's weight follows its angle, and so does a cable's: where the weight is fitted,
// the first must not pass for the second.
#include "diagnose/logs/weight_friction.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnose/logs/held_out.h"

namespace simgap {
namespace {

/// A pendulum that swings widely. \param per_load  friction by its weight's torque; \param bend  by its angle.
PreparedLog pendulum(double per_load, double bend, bool weight_is_fitted) {
  constexpr double kRate = 50.0, kWeight = 1.2 * 9.81 * 0.3;  // [Hz], [N m]
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::string csv = "time_s,position_rad,motor_velocity_rad_s,motor_current_A\n";
  for (int i = 0; i < 6000; ++i) {
    const double t = i / kRate, angle = 0.7 + 0.9 * std::sin(0.8 * t) + 0.5 * std::sin(0.31 * t + 1.0);
    const double w = 0.72 * std::cos(0.8 * t) + 0.155 * std::cos(0.31 * t + 1.0);
    const double acceleration = -0.576 * std::sin(0.8 * t) - 0.04805 * std::sin(0.31 * t + 1.0);
    const double load = kWeight * std::sin(angle) + 1.2 * 0.3 * 0.3 * acceleration;
    const double dry = 0.3 * std::exp(bend * angle) + per_load * std::abs(kWeight * std::sin(angle));
    csv += fmt::format("{:.2f},{:.6f},{:.6f},{:.6f}\n", t, angle, w,
                       load + (w > 0.0 ? 1.0 : -1.0) * dry + 0.2 * w + 0.02 * noise(random));
  }
  const std::string bench = fmt::format("format: simgap/bench/1\nload: pendulum\nlength_m: 0.3\nmass_kg: {}\n",
                                        weight_is_fitted ? "fit" : "1.2");
  return prepareLog(CsvTable::parse(csv, "log.csv"), readBench(YamlNode::parse(bench, "rig.yaml")),
                    ActuatorKind::kFriction);
}

struct BendGains {
  double alone = 0.0;
  std::optional<double> beside;
};

/// Shares of the squared error that bending explains.
BendGains bendGains(const PreparedLog& log) {
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("coulomb"), log.data, splitLog(log, options).training, options);
  Fitted rest = search.fit({}, nullptr);
  search.validate(rest);
  const Fitted full = search.tryAll(rest, {{&actuator_effects::find("bend-friction"), {}, {}}})[0].fitted;
  BendGains gains{1.0 - full.mse / rest.mse, {}};
  if (const auto weight = besideWeightFriction(search, rest, full)) {
    gains.beside = 1.0 - weight->full.mse / weight->rest.mse;
  }
  return gains;
}

TEST(WeightFriction, ThatGrowsWithAFittedWeightIsNoBending) {
  const BendGains gains = bendGains(pendulum(0.15, 0.0, true));
  EXPECT_GT(gains.alone, 0.1);  // it fits better: that is the trap
  ASSERT_TRUE(gains.beside);
  EXPECT_LT(*gains.beside, LogDiagnosisOptions().least_gain);
}

TEST(WeightFriction, LeavesBendingThatIsThere) {
  const BendGains gains = bendGains(pendulum(0.0, 0.5, true));
  ASSERT_TRUE(gains.beside);
  EXPECT_GT(*gains.beside, 0.3);
}

TEST(WeightFriction, IsNotLookedAtWhereTheWeightIsKnown) {
  EXPECT_FALSE(bendGains(pendulum(0.15, 0.0, false)).beside);  // load-dependence is asked for there
}

}  // namespace
}  // namespace simgap
