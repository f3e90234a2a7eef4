// Efforts that are faster than the motion which was worked out beside them. The drives are simulated here, step by
// step.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <random>

#include "simgap/measure/logs/bench.h"
#include "simgap/measure/logs/friction_rows.h"
#include "support/current_log.h"

namespace simgap::test {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr double kInertia = 0.012, kTorquePerAmpere = 1.2, kFriction = 0.05;  // [kg m^2], [Nm/A], [Nm]

/// A free axis behind a position controller that rings at `ring_Hz` (0: it follows a slow sine without ringing), logged
/// 100 times a second by an encoder of 4096 counts. \param ripple  [A] of current that moves nothing, thirty times a
/// second
ActuatorLog recorded(double ring_Hz, double ripple) {
  constexpr double kStep = 1e-4, kSeconds = 60.0;
  constexpr int kStepsPerRow = 100;
  const double count = 2.0 * std::numbers::pi / 4096.0;
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, 0.01);
  ActuatorLog log = currentLog("log.csv");
  log.session_names = {""};
  double angle = 0.0, speed = 0.0;
  for (int i = 0; i * kStep < kSeconds; ++i) {
    const double t = i * kStep, w = 2.0 * std::numbers::pi * 0.4;
    const double jumps = (static_cast<int>(t / 1.5037) * 7 % 5 - 2) * 0.5;
    const double stiffness = kInertia * std::pow(2.0 * std::numbers::pi * ring_Hz, 2);
    const double torque = ring_Hz > 0.0 ? stiffness * (jumps - angle) - 0.1 * speed
                                        : -kInertia * w * w * std::sin(w * t) + kFriction * std::copysign(1.0, speed);
    const double pushed = speed + kStep * torque / kInertia, stop = kStep * kFriction / kInertia;
    if (ring_Hz > 0.0) {
      speed = std::abs(pushed) < stop ? 0.0 : pushed - std::copysign(stop, pushed);
      angle += kStep * speed;
    } else {
      speed = w * std::cos(w * t);
      angle = std::sin(w * t);
    }
    if (i % kStepsPerRow != 0) continue;
    const double fast = ripple * std::sin(2.0 * std::numbers::pi * 30.0 * t);
    const double error = noise(random);
    log.time.push_back(t);
    log.session.push_back(0);
    log.position.push_back(count * std::round(angle / count));
    log.effort.push_back(torque / kTorquePerAmpere + fast + error);
  }
  return log;
}

FrictionData prepared(const ActuatorLog& log) {
  Bench bench;
  bench.load = BenchLoad::kFreeAxis;
  bench.inertia.value = kInertia;
  FrictionDataOptions options;
  options.all_rows = true;
  return prepareFrictionData(log, bench, options);
}

/// Torque per ampere, by plain least squares over the rows that count.
double torquePerAmpere(const FrictionData& data, const Eigen::ArrayXd& effort) {
  Eigen::MatrixXd x(effort.size(), 4);
  x << data.load, data.direction, data.velocity, Eigen::ArrayXd::Ones(effort.size());
  Eigen::VectorXd y = effort;
  for (Eigen::Index i = 0; i < effort.size(); ++i) {
    if (data.keep[static_cast<std::size_t>(i)]) continue;
    x.row(i).setZero();
    y[i] = 0.0;
  }
  return 1.0 / Eigen::VectorXd(x.colPivHouseholderQr().solve(y))[0];
}

Eigen::ArrayXd effortOf(const ActuatorLog& log) {
  return Eigen::Map<const Eigen::ArrayXd>(log.effort.data(), std::ssize(log.effort));
}

TEST(ParallelFilter, AnInertiaThatRingsNeedsTheTorqueItNeeds) {
  const ActuatorLog log = recorded(7.0, 0.0);
  const FrictionData data = prepared(log);
  EXPECT_THAT(data.warnings, Contains(HasSubstr("was smoothed like the motion, 10 Hz")));
  EXPECT_NEAR(torquePerAmpere(data, data.effort), kTorquePerAmpere, 0.02 * kTorquePerAmpere);
  EXPECT_LT(torquePerAmpere(data, effortOf(log)), 0.85 * kTorquePerAmpere);  // as it was logged: the trap
}

TEST(ParallelFilter, ACurrentThatIsNoFasterThanItsMotionStays) {
  const ActuatorLog log = recorded(0.0, 0.0);
  EXPECT_TRUE((prepared(log).effort == effortOf(log)).all());
}

TEST(ParallelFilter, RippleThatMovesNothingStays) {
  const ActuatorLog log = recorded(0.0, 0.2);
  EXPECT_TRUE((prepared(log).effort == effortOf(log)).all());
}

}  // namespace
}  // namespace simgap::test
