// Unknown constants of a pendulum rig, found together with friction. The motion and its derivatives are sums of sines
// worked out by hand; the effort follows from the moment of a weight and Coulomb + viscous friction.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "simgap/core/error.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "support/current_log.h"

namespace simgap {
namespace {

using testing::HasSubstr;

struct Truth {
  double gain = 0.8, coulomb = 0.12, viscous = 0.03;
  double mass = 0.9, length = 0.25, angle = 0.3, inertia = 0.02;
};

ActuatorLog swing(const Truth& truth, double noise) {
  ActuatorLog log = test::currentLog("pendulum.csv");
  log.session_names = {"0"};
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (int i = 0; i < 24000; ++i) {
    const double t = 0.005 * i;
    const double angle = 1.1 * std::sin(0.9 * t) + 0.5 * std::sin(2.3 * t + 1.0);
    const double speed = 0.99 * std::cos(0.9 * t) + 1.15 * std::cos(2.3 * t + 1.0);
    const double acceleration = -0.891 * std::sin(0.9 * t) - 2.645 * std::sin(2.3 * t + 1.0);
    const double weight = truth.mass * 9.81 * truth.length * std::sin(angle - truth.angle);
    const double inertial = (truth.mass * truth.length * truth.length + truth.inertia) * acceleration;
    const double friction = std::copysign(truth.coulomb, speed) + truth.viscous * speed;
    log.time.push_back(t);
    log.position.push_back(angle);
    log.velocity.push_back(speed);
    log.effort.push_back((weight + inertial + friction) / truth.gain + noise * normal(random));
    log.session.push_back(0);
  }
  return log;
}

Bench pendulumBench(const std::string& constants) {
  return readBench(
      YamlNode::parse("format: simgap/bench/1\nload: pendulum\nbandwidth_Hz: 20\n" + constants, "rig.yaml"));
}

FrictionFit fitPendulum(const std::string& constants, const FrictionFitOptions& options = {}) {
  return fitFriction(friction::find("coulomb"), prepareFrictionData(swing({}, 0.02), pendulumBench(constants), {}),
                     options);
}

FrictionFitOptions gainKnown() {
  FrictionFitOptions options;
  options.fixed = {{"k_a", 0.8}};
  return options;
}

void expectCovered(const FrictionFit& fit, std::string_view name, double truth, double most) {
  const auto estimate = std::ranges::find(fit.uncertainty.estimates, name, &Estimate::name);
  ASSERT_NE(estimate, fit.uncertainty.estimates.end()) << name;
  EXPECT_NEAR(estimate->value, truth, 4.0 * estimate->sd + 1e-3 * truth) << name;
  EXPECT_LT(estimate->sd, most) << name;
}

TEST(Pendulum, AngleOffsetOfAKnownBob) {
  const FrictionFit fit = fitPendulum("mass_kg: 0.9\nlength_m: 0.25\ninertia_kg_m2: 0.02\nangle_offset_rad: fit\n");
  expectCovered(fit, "angle_offset", 0.3, 0.01);
  expectCovered(fit, "k_a", 0.8, 0.01);
  EXPECT_EQ(fit.uncertainty.estimates.size(), 4u);  // k_a, tau_c, k_v, angle: sine and cosine are one unknown
}

/// The gain is told by the weight: beside a fitted inertia the known one of the bob tells nothing of it.
TEST(Pendulum, AngleAndInertiaOfAKnownBobByEveryLaw) {
  const FrictionData data = prepareFrictionData(
      swing({}, 0.02), pendulumBench("mass_kg: 0.9\nlength_m: 0.25\ninertia_kg_m2: fit\nangle_offset_rad: fit\n"), {});
  for (const char* law : {"coulomb", "stribeck", "classic"}) {
    const FrictionFit fit = fitFriction(friction::find(law), data, {});
    EXPECT_NEAR(fit.value("k_a"), 0.8, 0.01) << law;
    EXPECT_NEAR(fit.value("angle_offset"), 0.3, 0.01) << law;
    EXPECT_NEAR(fit.value("inertia"), 0.02, 0.004) << law;
  }
}

TEST(Pendulum, LengthAngleAndInertia) {
  const FrictionFit fit =
      fitPendulum("mass_kg: 0.9\nlength_m: fit\ninertia_kg_m2: fit\nangle_offset_rad: fit\n", gainKnown());
  expectCovered(fit, "length", 0.25, 0.005);
  expectCovered(fit, "angle_offset", 0.3, 0.01);
  expectCovered(fit, "total_inertia", 0.9 * 0.25 * 0.25 + 0.02, 0.005);
}

TEST(Pendulum, LengthWithAKnownAngle) {
  const FrictionFit fit =
      fitPendulum("mass_kg: 0.9\nlength_m: fit\ninertia_kg_m2: fit\nangle_offset_rad: 0.3\n", gainKnown());
  expectCovered(fit, "length", 0.25, 0.005);
  expectCovered(fit, "total_inertia", 0.9 * 0.25 * 0.25 + 0.02, 0.005);
}

TEST(Pendulum, ABoundIsHeldThoughTheSearchRelaxesIt) {
  FrictionFitOptions options;
  options.bounds = {{"angle_offset", {-0.1, 0.1}}};
  const FrictionFit fit =
      fitPendulum("mass_kg: 0.9\nlength_m: 0.25\ninertia_kg_m2: 0.02\nangle_offset_rad: fit\n", options);
  EXPECT_DOUBLE_EQ(fit.value("angle_offset"), 0.1);
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

TEST(Pendulum, SaysWhatNoMotionCanTellApart) {
  EXPECT_THAT(errorOf([] { pendulumBench("mass_kg: fit\nlength_m: fit\ninertia_kg_m2: fit\n"); }),
              HasSubstr("only mass times length acts"));
  EXPECT_THAT(errorOf([] { pendulumBench("mass_kg: 0.9\nlength_m: fit\n"); }),
              HasSubstr("expected inertia_kg_m2: fit"));
  EXPECT_THAT(errorOf([] { pendulumBench("inertia_kg_m2: 1\nlength_m: 0.2\nangle_offset_rad: fit\n"); }),
              HasSubstr("angle_offset_rad: fit without a mass"));
  EXPECT_THAT(errorOf([] { fitPendulum("mass_kg: fit\nlength_m: 0.25\ninertia_kg_m2: fit\nangle_offset_rad: fit\n"); }),
              HasSubstr("only their ratio acts on this log"));
}

}  // namespace
}  // namespace simgap
