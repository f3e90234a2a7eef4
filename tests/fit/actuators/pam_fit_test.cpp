#include "simgap/fit/actuators/pam_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kA = 0.06, kB = -0.12, kC = 0.015, kSpring = 20000.0;  // some 5 kN at 0.6 MPa; 4 kN stretch by 0.2

/// Force by bisection of f = p g(eps + f / k): no formula of the model's root.
double bisected(double pressure, double eps, double spring) {
  const auto excess = [&](double f) {
    const double x = eps + f / spring;
    return pressure * (kA * x * x + kB * x + kC) - f;
  };
  if (excess(0.0) <= 0.0) return 0.0;
  double low = 0.0, high = 2e4;
  for (int i = 0; i < 200; ++i) (excess(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
  return low;
}

PamLog rig(double spring, double noise) {
  PamLog log;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int p = 1; p <= 6; ++p) {
    for (int e = 0; e <= 40; ++e) {
      log.pressure.push_back(1e5 * p);
      log.contraction.push_back(-0.03 + 0.2 * e / 40.0);
      log.force.push_back(bisected(log.pressure.back(), log.contraction.back(), spring) + noise * normal(random));
      log.session.push_back(0);
    }
  }
  log.session_names = {"all"};
  log.file = "pam.csv";
  return log;
}

TEST(Pam, ClosedFormIsTheRootOfTheImplicitEquation) {
  const Pam muscle{kA, kB, kC, kSpring, -0.1, 0.9};
  for (const double p : {5e4, 3e5, 6e5}) {
    for (const double eps : {-0.05, 0.0, 0.1, 0.2}) {
      EXPECT_NEAR(muscle.force(p, eps).value(), bisected(p, eps, kSpring), 1e-6 * 5000.0) << p << " " << eps;
    }
  }
}

/// Where the spring is too soft no force solves f = p g(eps + f / k): the excess has its extremum at the turning point.
TEST(Pam, TurningForceIsWhereTheEquationComesNearest) {
  const Pam muscle{kA, kB, 0.08, 4000.0, -10.0, 10.0};
  const double p = 6e5, eps = -0.05;
  ASSERT_FALSE(muscle.force(p, eps).has_value());
  const auto excess = [&](double f) { return p * muscle.area(eps + f / muscle.k) - f; };
  const double turn = muscle.turningForce(p, eps), h = 1e-3 * std::abs(turn);
  EXPECT_NEAR((excess(turn + h) - excess(turn - h)) / (2.0 * h), 0.0, 1e-9);
  EXPECT_GT(excess(turn + h), excess(turn));
  EXPECT_GT(excess(turn - h), excess(turn));
  EXPECT_GT(excess(turn), 0.0);  // no root
}

/// Stiff enough for a root by a hair, the force is the turning force.
TEST(Pam, ForceGoesOverIntoTheTurningForce) {
  Pam muscle{kA, kB, 0.08, 1e3, -10.0, 10.0};
  const double p = 6e5, eps = -0.05;
  double soft = 1e3, stiff = 1e6;
  ASSERT_FALSE(muscle.force(p, eps).has_value());
  for (int i = 0; i < 200; ++i) {
    muscle.k = 0.5 * (soft + stiff);
    (muscle.force(p, eps) ? stiff : soft) = muscle.k;
  }
  muscle.k = stiff;
  EXPECT_NEAR(muscle.force(p, eps).value(), muscle.turningForce(p, eps), 1e-4 * muscle.turningForce(p, eps));
}

TEST(Pam, PressureInvertsForce) {
  const Pam muscle{kA, kB, kC, kSpring, -0.1, 0.9};
  for (const double p : {1e5, 6e5}) {
    const double f = muscle.force(p, 0.05).value();
    EXPECT_NEAR(muscle.pressure(f, 0.05).value(), p, 1e-9 * p);
  }
}

TEST(Pam, RefusesWhatLiesOutsideItsRangeAndNeverPushes) {
  const Pam muscle{kA, kB, kC, kSpring, -0.05, 0.25};
  EXPECT_FALSE(muscle.force(6e5, 0.3).has_value());
  EXPECT_FALSE(muscle.pressure(4000.0, 0.2).has_value());
  EXPECT_FALSE(muscle.pressure(-1.0, 0.1).has_value());
  EXPECT_EQ(muscle.force(6e5, 0.2).value_or(-1.0), Pam({kA, kB, kC, kSpring, -1.0, 1.0}).force(6e5, 0.2).value());
  EXPECT_EQ(Pam({kA, kB, -0.01, kSpring, -1.0, 1.0}).force(1e5, 0.2).value(), 0.0);
}

TEST(PamFit, RecoversTheMuscleAndItsSpring) {
  const PamFit fit = fitPam(rig(kSpring, 0.0), {});
  EXPECT_NEAR(fit.theta[0], kA, 1e-6 * kA);
  EXPECT_NEAR(fit.theta[1], kB, -1e-6 * kB);
  EXPECT_NEAR(fit.theta[2], kC, 1e-6 * kC);
  EXPECT_NEAR(fit.theta[3], kSpring, 1e-6 * kSpring);
}

TEST(PamFit, TwoStagesAsInThePaper) {
  PamFitOptions without;
  without.spring = false;
  const PamFit maker = fitPam(rig(1e12, 0.0), without);
  PamFitOptions options;
  options.fixed = {{"a", maker.theta[0]}, {"b", maker.theta[1]}, {"c", maker.theta[2]}};
  const PamFit fit = fitPam(rig(kSpring, 20.0), options);
  EXPECT_EQ(fit.parameters, 1u);
  EXPECT_NEAR(fit.theta[3], kSpring, 0.01 * kSpring);
  without.fixed = options.fixed;
  EXPECT_LT(fit.mse, 0.2 * fitPam(rig(kSpring, 20.0), without).mse);
}

TEST(PamFit, TiedParametersFollowTheGeometry) {
  PamFitOptions options;
  options.tied = true;
  const PamFit fit = fitPam(rig(kSpring, 0.0), options);
  EXPECT_DOUBLE_EQ(fit.theta[1], -2.0 * fit.theta[0]);
  EXPECT_EQ(fit.parameters, 3u);
  const Eigen::MatrixXd& covariance = fit.uncertainty.covariance;
  EXPECT_DOUBLE_EQ(covariance(1, 1), 4.0 * covariance(0, 0));
  EXPECT_DOUBLE_EQ(covariance(1, 2), -2.0 * covariance(0, 2));
  // a = 3 pi D^2 / (4 tan^2 psi), c = (pi D^2 / 4)(3 / tan^2 psi - 1 / sin^2 psi): 002 eq. 12.
  const double d = 0.02, psi = 0.45, q = 3.14159265358979 * d * d / 4.0;
  const auto geometry = geometryOf(3.0 * q / std::pow(std::tan(psi), 2),
                                   q * (3.0 / std::pow(std::tan(psi), 2) - 1.0 / std::pow(std::sin(psi), 2)));
  ASSERT_TRUE(geometry);
  EXPECT_NEAR(geometry->diameter, d, 1e-9);
  EXPECT_NEAR(geometry->angle, psi, 1e-9);
}

/// What is said of a rig's log when one of its channels is turned round.
std::string saidOfTurned(std::vector<double> PamLog::*channel, double spring) {
  PamLog log = rig(spring, 20.0);
  for (double& value : log.*channel) value = -value;
  return errorOf([&] { fitPam(log, {}); });
}

TEST(PamFit, NamesTheChannelWithTheOppositeSign) {
  for (const double spring : {kSpring, 1e12}) {
    EXPECT_THAT(saidOfTurned(&PamLog::force, spring),
                AllOf(HasSubstr("pam.csv: force_N has the opposite sign"), HasSubstr("--map force_N=COLUMN*-1")));
    EXPECT_THAT(saidOfTurned(&PamLog::contraction, spring), HasSubstr("pam.csv: contraction has the opposite sign"));
  }
}

/// Of a tendon that hardly stretches the rows say how stiff it is at least, not at most.
TEST(PamFit, ATendonMayBeStifferByAnyAmount) {
  const PamFit fit = fitPam(rig(4e6, 60.0), {});
  const Estimate& k = fit.uncertainty.estimates[3];
  EXPECT_GT(k.lower95, 2e4) << k.value << " ± " << k.sd;
  EXPECT_GT(k.upper95, 4e6);
  EXPECT_LT(k.lower95, 4e6);
}

TEST(PamFit, SaysHowManyForcesNoMuscleHas) {
  PamLog log = rig(kSpring, 20.0);
  EXPECT_THAT(fitPam(log, {}).warnings, Not(Contains(HasSubstr("the muscle pushes"))));
  for (std::size_t i = 0; i < 5; ++i) log.force[i] = -400.0;
  EXPECT_THAT(fitPam(log, {}).warnings,
              Contains(HasSubstr("in 5 of 246 rows the muscle pushes, in 0 it pulls without pressure")));
}

// At one pressure a stiff tendon with another a fits to the noise, within narrow intervals.
TEST(PamFit, SaysThatOnePressureTellsNothingOfTheTendon) {
  const PamLog all = rig(kSpring, 0.0);
  PamLog log = all;
  log.pressure.clear(), log.contraction.clear(), log.force.clear(), log.session.clear();
  for (std::size_t i = 0; i < all.rows(); ++i) {
    if (all.pressure[i] != all.pressure.back()) continue;
    log.pressure.push_back(all.pressure[i]), log.contraction.push_back(all.contraction[i]);
    log.force.push_back(all.force[i]), log.session.push_back(0);
  }
  PamFitOptions options;
  options.spring = false;
  EXPECT_THAT(fitPam(log, options).warnings, Contains(HasSubstr("the pressure is constant")));
  EXPECT_THAT(fitPam(all, options).warnings, Not(Contains(HasSubstr("the pressure is constant"))));
  options.fixed = {{"k", kSpring}};
  EXPECT_THAT(fitPam(log, options).warnings, Not(Contains(HasSubstr("the pressure is constant"))));
}

TEST(PamFit, RefusesLogsThatCannotAnswer) {
  PamLog log = rig(kSpring, 0.0);
  log.force.assign(log.force.size(), 12.0);
  EXPECT_THAT(errorOf([&] { fitPam(log, {}); }), HasSubstr("force_N is constant"));
  log = rig(kSpring, 0.0);
  log.contraction[0] = 12.0;
  EXPECT_THAT(errorOf([&] { fitPam(log, {}); }), HasSubstr("is the unit"));
}

}  // namespace
}  // namespace simgap::test
