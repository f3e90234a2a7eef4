// Under a law without friction by the load a Stribeck curve per load fits better than nothing: it must not be named for
// that, and one that is there must stay.
#include "diagnose/logs/load_friction.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnose/logs/held_out.h"

namespace simgap {
namespace {

/// A pendulum of known weight. \param per_load  friction by the square of its torque, of its largest; \param slow  more
/// friction in slow motion [N m].
PreparedLog knownPendulum(double per_load, double slow) {
  constexpr double kRate = 50.0, kWeight = 1.2 * 9.81 * 0.3;  // [Hz], [N m]
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::string csv = "time_s,position_rad,motor_velocity_rad_s,motor_current_A\n";
  for (int i = 0; i < 6000; ++i) {
    const double t = i / kRate, angle = 0.2 + 0.9 * std::sin(0.8 * t) + 0.5 * std::sin(0.31 * t + 1.0);
    const double w = 0.72 * std::cos(0.8 * t) + 0.155 * std::cos(0.31 * t + 1.0);
    const double acceleration = -0.576 * std::sin(0.8 * t) - 0.04805 * std::sin(0.31 * t + 1.0);
    const double torque = kWeight * std::sin(angle), load = torque + 1.2 * 0.3 * 0.3 * acceleration;
    const double dry = 0.3 + per_load * torque * torque / kWeight + slow / (1.0 + (w / 0.08) * (w / 0.08));
    csv += fmt::format("{:.2f},{:.6f},{:.6f},{:.6f}\n", t, angle, w,
                       load + (w > 0.0 ? 1.0 : -1.0) * dry + 0.2 * w + 0.1 * noise(random));
  }
  const std::string bench = "format: simgap/bench/1\nload: pendulum\nlength_m: 0.3\nmass_kg: 1.2\n";
  return prepareLog(CsvTable::parse(csv, "log.csv"), readBench(YamlNode::parse(bench, "rig.yaml")),
                    ActuatorKind::kFriction);
}

struct SlowGains {
  double alone = 0.0;
  std::optional<double> beside;
};

/// Shares of the squared error that an effect explains. \param law  that lacks it
SlowGains gainsOf(const PreparedLog& log, const char* effect, const char* law = "coulomb") {
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find(law), log.data, splitLog(log, options).training, options);
  Fitted rest = search.fit({}, nullptr);
  search.validate(rest);
  const Hypothesis hypothesis{&actuator_effects::find(effect), {}, {}};
  const Fitted full = search.tryAll(rest, {hypothesis})[0].fitted;
  SlowGains gains{1.0 - full.mse / rest.mse, {}};
  if (const auto load = besideLoadFriction(search, rest, full, *hypothesis.effect)) {
    gains.beside = 1.0 - load->full.mse / load->rest.mse;
  }
  return gains;
}

TEST(LoadFriction, IsNoStribeckCurve) {
  const SlowGains gains = gainsOf(knownPendulum(0.3, 0.0), "stribeck");
  EXPECT_GT(gains.alone, 0.05);  // it fits better: that is the trap
  ASSERT_TRUE(gains.beside);
  EXPECT_LT(*gains.beside, LogDiagnosisOptions().least_gain);
}

TEST(LoadFriction, LeavesAStribeckCurveThatIsThere) {
  const SlowGains gains = gainsOf(knownPendulum(0.3, 0.3), "stribeck");
  ASSERT_TRUE(gains.beside);
  EXPECT_GT(*gains.beside, 0.1);
}

TEST(LoadFriction, NeedNotHoldBesideItself) {
  const PreparedLog log = knownPendulum(0.3, 0.0);
  EXPECT_FALSE(gainsOf(log, "load-dependence").beside);
  EXPECT_FALSE(gainsOf(log, "inertia", "load-coulomb").beside);  // the law has it
}

}  // namespace
}  // namespace simgap
