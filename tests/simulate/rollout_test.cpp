// Motions of second order: closed forms, energy, dampers, commands, and what happens when the step is far too large.
#include "simgap/simulate/rollout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "simgap/core/joint_kind.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "support/arms.h"

namespace simgap {
namespace {

using Eigen::Vector3d;

RolloutOptions rolloutStep(double step) {
  RolloutOptions options;
  options.step = step;
  return options;
}

MotionCommands heldCommands(const ArmModel& model, CommandKind kind, double value) {
  MotionCommands commands;
  commands.kinds.assign(model.muscles.size(), kind);
  commands.times = {0.0};
  commands.values = Eigen::MatrixXd::Constant(std::ssize(model.muscles), 1, value);
  return commands;
}

std::vector<double> rolloutTimesTo(double end, double interval) {
  std::vector<double> times;
  for (int i = 0; i * interval < end + 1e-9; ++i) times.push_back(i * interval);
  return times;
}

MotionTrack playRollout(const ArmModel& model, double step, const MotionStart& start,
                        const std::vector<double>& times) {
  Rollout rollout(model, rolloutStep(step));
  MotionTrack track;
  EXPECT_TRUE(rollout.run(heldCommands(model, CommandKind::kSetpoint, 0.0), start, times, track).finished);
  return track;
}

// Arithmetic-geometric mean, by which Gauss gave the complete elliptic integral.
double meanOf(double a, double b) {
  while (std::abs(a - b) > 1e-15 * a) {
    const double arithmetic = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = arithmetic;
  }
  return a;
}

double rolloutPeriod(const ArmModel& model, double amplitude, double step) {
  const std::vector<double> times = rolloutTimesTo(8.0, step);
  const MotionTrack track = playRollout(model, step, {{test::hingeAt(amplitude)}}, times);
  std::vector<double> crossings;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double before = track.joints[i - 1].angle, now = track.joints[i].angle;
    if (before < 0.0 && now >= 0.0) crossings.push_back(times[i] - step * now / (now - before));
  }
  EXPECT_GE(crossings.size(), 4U);
  return (crossings[3] - crossings[0]) / 3.0;
}

TEST(Rollout, PendulumSwingsWithThePeriodOfTheEllipticIntegral) {
  const double slow = std::sqrt(test::kPendulumMass * test::kGravity * test::kPendulumLength / test::kPendulumInertia);
  for (const double amplitude : {0.05, 0.8, 2.0}) {
    const double period = 2.0 * std::numbers::pi / (slow * meanOf(1.0, std::cos(0.5 * amplitude)));
    EXPECT_NEAR(rolloutPeriod(test::pendulum(), amplitude, 0.001) / period, 1.0, 1e-5) << amplitude;
    EXPECT_NEAR(rolloutPeriod(test::pendulum(), amplitude, 0.002) / period, 1.0, 1e-4) << amplitude;
  }
}

// A hinge about the vertical feels no weight: I q'' + c q' + k q = 0 with a cord's pair as the spring would need
// geometry; a damper alone, q' = w0 exp(-c t / I), says whether the dampers are of second order.
TEST(Rollout, ADampedHingeSlowsDownExponentially) {
  ArmModel model = test::pendulum();
  model.joints[0].axis = Vector3d::UnitZ();
  model.bodies[1].parts[0].position = {0.15, 0.0, 0.0};
  model.joints[0].viscous_friction = 0.5;
  const double rate = 0.5 / test::kPendulumInertia;  // 11 /s
  const std::vector<double> times = {0.3};
  const auto speed = [&](double step) {
    return playRollout(model, step, {{test::hingeAt(0.0)}, {{3.0, 0.0, 0.0}}}, times).joint_velocities[0].x();
  };
  const double exact = 3.0 * std::exp(-0.3 * rate);
  EXPECT_NEAR(speed(0.001) / exact, 1.0, 1e-4);
  EXPECT_NEAR((speed(0.002) - exact) / (speed(0.001) - exact), 4.0, 0.1);
}

const std::vector<Part> kLopsidedBox = {test::cylinder(0.6, {0.01, 0.02, -0.1}, {0.3, -0.2, 1.0}),
                                        test::box(0.4, {-0.03, 0.01, -0.16}, {0.05, 0.09, 0.03}),
                                        test::sphere(0.2, {0.02, -0.04, -0.05}, 0.03)};

// The judge sums over the parts (support/arms.h): it knows no mass matrix.
double energyDrift(const ArmModel& model, double step, const MotionStart& start, double end) {
  const std::vector<double> times = rolloutTimesTo(end, 0.01);
  const MotionTrack track = playRollout(model, step, start, times);
  const auto mechanics = [&](std::size_t row) {
    const auto velocities = std::span(track.joint_velocities).subspan(row * track.joint_count, track.joint_count);
    return test::mechanics(model, track.jointsAt(row), velocities);
  };
  const test::Mechanics first = mechanics(0);
  double drift = 0.0, scale = first.kinetic;
  for (std::size_t row = 0; row < times.size(); ++row) {
    scale = std::max(scale, mechanics(row).kinetic);
    drift = std::max(drift, std::abs(mechanics(row).energy() - first.energy()));
  }
  return drift / scale;
}

TEST(Rollout, ATumblingBallKeepsItsEnergy) {
  ArmModel model = test::torso();
  test::addLink(model, 0, JointType::kSpherical, {0.1, 0.0, 0.2}, kLopsidedBox).child_position = {0.02, -0.01, 0.03};
  const MotionStart start{{test::ballAt(0.9, {1.0, 2.0, -1.0})}, {{3.0, -2.0, 4.0}}};
  EXPECT_LT(energyDrift(model, 0.002, start, 10.0), 1e-3);
  EXPECT_LT(energyDrift(model, 0.001, start, 10.0), 3e-4);
}

TEST(Rollout, AChainKeepsItsEnergy) {
  ArmModel model = test::torso();
  test::addLink(model, 0, JointType::kSpherical, {0.1, 0.0, 0.2}, kLopsidedBox);
  test::addLink(model, 1, JointType::kRevolute, {0.0, 0.0, -0.2}, kLopsidedBox);
  test::addLink(model, 2, JointType::kSpherical, {0.0, 0.02, -0.2}, kLopsidedBox);
  const MotionStart start{{test::ballAt(0.4, {1.0, 1.0, 0.0}), test::hingeAt(0.8), test::ballAt(0.5, {0.0, 1.0, 2.0})},
                          {{1.0, -2.0, 1.5}, {2.0, 0.0, 0.0}, {-1.0, 1.0, 2.0}}};
  EXPECT_LT(energyDrift(model, 0.001, start, 2.0), 2e-3);
}

TEST(Rollout, TheStepBeginsAndEndsWhereBulletsDoes) {
  // Two integrators of the same arm meet as the step shrinks.
  const ArmModel model = test::exampleArm();
  const std::vector<double> times = {0.3};
  MotionTrack track;
  Rollout rollout(model, rolloutStep(0.0005));
  const MotionCommands commands = heldCommands(model, CommandKind::kSetpoint, 2.0);
  ASSERT_TRUE(rollout.run(commands, {}, times, track).finished);
  BulletArmOptions fine;
  fine.step = 0.00005;
  BulletArm arm(model, fine);
  arm.setShaftReferences(std::vector<double>(11, 2.0));
  for (int i = 0; i < 6000; ++i) arm.step();
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_LT(toDegrees(jointError(model.joints[j].type, track.joints[j], arm.jointPosition(j))), 0.05) << j;
  }
  for (std::size_t m = 0; m < 11; ++m) {
    EXPECT_NEAR(track.shafts(std::ssize(model.muscles) - 11 + static_cast<Eigen::Index>(m), 0), arm.shaftAngle(m),
                2e-3);
  }
}

TEST(Rollout, ComesToRestWhereTheEnergyIsLeast) {
  ArmModel model = test::exampleArm();
  for (Joint& joint : model.joints) {
    joint.coulomb_friction = 0.0;
    joint.viscous_friction *= 10.0;
  }
  Rollout rollout(model, rolloutStep(0.001));
  MotionTrack track;
  const std::vector<double> times = {20.0};
  ASSERT_TRUE(rollout.run(heldCommands(model, CommandKind::kSetpoint, 2.0), {}, times, track).finished);
  EquilibriumArm equilibrium(model);
  std::vector<double> shafts(11);
  for (Eigen::Index m = 0; m < 11; ++m) shafts[m] = track.shafts(m, 0);
  ASSERT_TRUE(equilibrium.solve(shafts).stable);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_LT(toDegrees(jointError(model.joints[j].type, track.joints[j], equilibrium.joints()[j])), 0.01) << j;
  }
}

TEST(Rollout, RepeatsToTheLastBitWhateverCameBefore) {
  const ArmModel model = test::exampleArm();
  ArmModel other = model;
  other.joints[0].viscous_friction *= 2.0;
  other.muscles[3].motor.coulomb_friction *= 2.0;
  const std::vector<double> times = rolloutTimesTo(0.5, 0.0037);
  MotionTrack first, again;
  Rollout rollout(model, rolloutStep(0.001));
  const MotionCommands commands = heldCommands(model, CommandKind::kSetpoint, 1.0);
  ASSERT_TRUE(rollout.run(commands, {}, times, first).finished);
  rollout.setModel(other);
  ASSERT_TRUE(rollout.run(commands, {}, times, again).finished);
  EXPECT_NE(first.shafts, again.shafts);
  rollout.setModel(model);
  ASSERT_TRUE(rollout.run(commands, {}, times, again).finished);
  EXPECT_EQ(first.shafts, again.shafts);
  EXPECT_EQ(first.joints.back().angle, again.joints.back().angle);
  EXPECT_EQ(first.currents, again.currents);
}

/// A cord at rest pulls with k x, and a shaft wound by more has its cord longer by what it wound. The row has the pull
/// of the first step, in whose middle bodies have moved a little: the shorter the step, the less.
TEST(Rollout, TheFirstRowOfAStartThatNothingSettledHasTheTensionOfItsCords) {
  const ArmModel model = test::exampleArm();
  const auto firstRow = [&](double shaft) {
    MotionStart start;
    start.shafts.assign(model.muscles.size(), shaft);
    return playRollout(model, 1e-5, start, {0.0});
  };
  const MotionTrack track = firstRow(3.0), wound = firstRow(3.5);
  int taut = 0;
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    const ShockCord& cord = model.muscles[m].shock_cord;
    const auto i = static_cast<Eigen::Index>(m);
    const double expansion = track.cord_lengths(i, 0) - cord.rest_length;
    EXPECT_NEAR(track.forces(i, 0), std::max(0.0, cord.stiffness * expansion), 0.005) << m;
    EXPECT_NEAR(wound.cord_lengths(i, 0) - track.cord_lengths(i, 0), 0.5 * model.muscles[m].spindle_radius, 1e-6) << m;
    taut += track.forces(i, 0) > 1.0 ? 1 : 0;
  }
  EXPECT_GT(taut, 5);
}

TEST(Rollout, SaysWhenAndWhereItBlewUp) {
  ArmModel model = test::exampleArm();
  for (Muscle& muscle : model.muscles) muscle.shock_cord.stiffness = 1e9;
  Rollout rollout(model, rolloutStep(0.002));
  MotionTrack track;
  const std::vector<double> times = rolloutTimesTo(1.0, 0.01);
  const MotionOutcome outcome = rollout.run(heldCommands(model, CommandKind::kSetpoint, 10.0), {}, times, track);
  EXPECT_FALSE(outcome.finished);
  EXPECT_TRUE(outcome.joint >= 0 || outcome.muscle >= 0);
  EXPECT_LT(outcome.rows, times.size());
  EXPECT_NEAR(static_cast<double>(outcome.rows) * 0.01, outcome.time, 0.011);
}

TEST(Rollout, HoldsOrInterpolatesBetweenRows) {
  MotionCommands commands;
  commands.kinds = {CommandKind::kVoltage};
  commands.times = {0.0, 1.0, 3.0};
  commands.values.resize(1, 3);
  commands.values << 1.0, 2.0, 6.0;
  std::size_t row = 0;
  std::vector<double> value(1);
  const auto at = [&](double time) {
    commands.at(time, row, value);
    return value[0];
  };
  EXPECT_EQ(at(-1.0), 1.0);
  EXPECT_EQ(at(0.999), 1.0);
  EXPECT_EQ(at(2.0), 2.0);
  EXPECT_EQ(at(9.0), 6.0);
  commands.linear = true;
  EXPECT_EQ(at(-1.0), 1.0);
  EXPECT_EQ(at(0.5), 1.5);
  EXPECT_EQ(at(2.0), 4.0);
  EXPECT_EQ(at(9.0), 6.0);
}

}  // namespace
}  // namespace simgap
