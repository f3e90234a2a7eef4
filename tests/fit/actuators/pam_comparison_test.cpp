#include "simgap/fit/actuators/pam_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace simgap {
namespace {

constexpr double kComparedA = 0.06, kB = -0.12, kC = 0.015;  // some 5 kN at 0.6 MPa

/// A rig that pulls a muscle out and lets it back, slowly, at one pressure after the other. Behind a tendon with a
/// spring the muscle itself is shorter by f / k; the force is then found by bisection.
PamLog comparedRig(double spring) {
  PamLog log;
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 5.0);  // [N]
  for (int i = 0; i < 1200; ++i) {
    const int level = 1 + i / 200;
    const double pressure = 1e5 * level, eps = -0.03 + 0.1 * (1.0 - std::cos(0.1 * i));
    double low = 0.0, high = 2e4;
    for (int k = 0; k < 100; ++k) {
      const double f = 0.5 * (low + high), x = eps + f / spring;
      (pressure * (kComparedA * x * x + kB * x + kC) > f ? low : high) = f;
    }
    log.time.push_back(0.1 * i);
    log.pressure.push_back(pressure);
    log.contraction.push_back(eps);
    log.force.push_back(low + noise(random));
    log.session.push_back(0);
  }
  log.session_names = {"all"};
  log.file = "pam.csv";
  return log;
}

TEST(PamComparison, FindsTheSpringThatIsThere) {
  const PamComparison found = comparePam(comparedRig(20000.0), {}, std::nullopt, {}, 5.0);
  ASSERT_EQ(found.candidates.size(), 2u);
  EXPECT_EQ(found.chosen().name, "spring");
  EXPECT_NEAR(found.chosen().fit.theta[3], 20000.0, 500.0);
  EXPECT_LT(*found.chosen().mse_heldout, 0.5 * *found.candidates[0].mse_heldout);
  EXPECT_EQ(found.chosen().fit.n, 1200u) << "the final fit has all rows";
}

TEST(PamComparison, ASpringAsStiffAsItMayBeIsNone) {
  const PamComparison found = comparePam(comparedRig(1e12), {}, std::nullopt, {}, 5.0);
  EXPECT_EQ(found.chosen().name, "no-spring");
}

TEST(PamComparison, SamplesThatStandAloneMoveNothing) {
  PamLog log = comparedRig(20000.0);
  const PamFit clean = comparePam(log, {}, std::nullopt, {}, 5.0).chosen().fit;
  for (const std::size_t row : {50u, 400u, 777u}) log.force[row] += 3000.0;
  repairSpikes(log);
  ASSERT_EQ(log.spikes.size(), 1u);
  EXPECT_EQ(log.spikes[0].channel, "force_N");
  EXPECT_EQ(log.spikes[0].rows.size(), 3u);
  const PamFit again = comparePam(log, {}, std::nullopt, {}, 5.0).chosen().fit;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(again.theta[i], clean.theta[i], 0.5 * clean.uncertainty.estimates[i].sd) << i;
  }
}

TEST(PamComparison, RowsHeldOutByTheUserStayOutOfTheFit) {
  const PamLog log = comparedRig(20000.0);
  Holdout holdout;
  holdout.rows.assign(log.rows(), false);
  std::fill(holdout.rows.begin() + 1000, holdout.rows.end(), true);
  holdout.words = "the highest pressure";
  const PamComparison found = comparePam(log, {}, std::nullopt, holdout, 5.0);
  EXPECT_EQ(found.heldout, "the highest pressure");
  for (const PamCandidate& c : found.candidates) EXPECT_EQ(c.fit.n, 1000u);
}

TEST(PamComparison, TheMakersCurvesAreTakenAsKnown) {
  PamFit maker;
  maker.theta = {kComparedA, kB, kC, 0.0};
  const PamComparison found = comparePam(comparedRig(20000.0), {}, maker, {}, 5.0);
  EXPECT_EQ(found.chosen().name, "spring");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(found.chosen().fit.theta[i], maker.theta[i]);
  EXPECT_EQ(found.chosen().fit.parameters, 1u);
}

}  // namespace
}  // namespace simgap
