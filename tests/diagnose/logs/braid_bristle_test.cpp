// A muscle's braid drags bristles along, which bend before they slip, also where there is little pressure.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "diagnose/logs/held_out.h"

namespace simgap {
namespace {

constexpr double kFriction = 5.0, kSlip = 0.05, kRange = 0.12;  // [N], share of the range, contraction

/// A muscle at several pressures, stretched and let go again and again, with a friction that is the same at all of
/// them: bristles that follow the contraction by steps (Prandtl's, not Dahl's).
PreparedLog braidedMuscle() {
  std::mt19937_64 random(2);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::string csv = "time_s,session,pressure_Pa,contraction,force_N\n";
  for (int session = 0; session < 6; ++session) {
    const double pressure = 1e5 + 8e4 * session;
    double bent = 0.0, before = 0.0;
    for (int i = 0; i < 800; ++i) {
      const double t = i / 40.0, e = 0.1 + 0.5 * kRange * std::sin(2.0 * std::numbers::pi * t / 6.0);
      bent = std::clamp(bent + (i > 0 ? e - before : 0.0) / (kSlip * kRange), -1.0, 1.0), before = e;
      const double force = pressure * (1.2e-3 * (1.0 - e) * (1.0 - e) - 3e-4) - kFriction * bent + 0.3 * noise(random);
      csv += fmt::format("{:.3f},{},{:.0f},{:.5f},{:.2f}\n", 25.0 * session + t, session, pressure, e, force);
    }
  }
  return prepareLog(CsvTable::parse(csv, "log.csv"), {}, ActuatorKind::kPam);
}

TEST(BraidBristle, IsFoundWithItsForceAndItsSlip) {
  const PreparedLog log = braidedMuscle();
  const LogDiagnosisOptions options;
  const LogSearch search(*actuator_equations::find(ActuatorKind::kPam), log.data, splitLog(log, options).training,
                         options);
  Fitted rest = search.fit({}, nullptr);
  search.validate(rest);
  const ActuatorEffect& sign = actuator_effects::find("contraction-hysteresis", "sign");
  const ActuatorEffect& bristle = actuator_effects::find("contraction-hysteresis", "bristle");
  const std::vector<Trial> trials = search.tryAll(rest, {{&sign, {}, {}}, {&bristle, {}, {}}});
  const Trial& found = trials[1];
  ASSERT_TRUE(found.gain);
  EXPECT_GT(found.gain->value, 0.9);
  EXPECT_LT(trials[0].gain_training, 0.8);  // in proportion to the pressure, and at once
  const std::size_t column = found.fitted.model->firstColumn(0), slip = found.fitted.model->firstParameter(0);
  EXPECT_NEAR(found.fitted.theta[column], kFriction, 0.1 * kFriction);
  EXPECT_LT(std::abs(found.fitted.theta[column + 1]) * 3e5, 0.1 * kFriction);
  EXPECT_NEAR(found.fitted.theta[slip], kSlip, 0.5 * kSlip);
}

}  // namespace
}  // namespace simgap
