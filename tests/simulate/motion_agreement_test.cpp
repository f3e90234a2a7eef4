// Motions of random arms against an integrator that knows no joint coordinates (reality/arm_trajectory.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reality/arm_trajectory.h"
#include "simgap/core/random.h"
#include "simgap/simulate/rollout.h"
#include "support/arms.h"
#include "support/statics.h"
#include "support/step_study.h"

namespace simgap {
namespace {

/// An arm whose every force is smooth: no limits, no Coulomb friction.
reality::Arm smoothArm(std::uint64_t seed) {
  reality::Arm arm = reality::randomArm(seed);
  for (reality::Link& link : arm.links) {
    link.coulomb = 0.0;
    link.lower = -INFINITY;
    link.upper = INFINITY;
  }
  return arm;
}

ArmModel smoothModel(const reality::Arm& arm) {
  ArmModel model = test::modelOf(arm, false);
  for (Muscle& muscle : model.muscles) muscle.motor.coulomb_friction = muscle.gearbox.coulomb_friction = 0.0;
  return model;
}

reality::SmoothDrive driveOf(const ArmModel& model) {
  const Motor& motor = model.muscles.front().motor;
  const Gearbox& gearbox = model.muscles.front().gearbox;
  return {motor.resistance, motor.inductance,         motor.back_emf_constant, motor.torque_constant,
          motor.inertia,    motor.viscous_friction,   gearbox.ratio,           gearbox.efficiency,
          gearbox.inertia,  gearbox.viscous_friction, motor.supply_voltage};
}

constexpr double kInterval = 0.1, kEnd = 2.0;  // [s]

/// Largest angle of a joint between the simulation and the judge over two seconds, per step. [rad]
std::vector<double> largestDifferences(std::uint64_t seed, const std::vector<double>& steps) {
  const reality::Arm arm = smoothArm(seed);
  const ArmModel model = smoothModel(arm);
  std::vector<double> references(model.muscles.size());
  const CounterRandom random(seed);
  for (std::uint32_t m = 0; m < references.size(); ++m) references[m] = 3.0 * random.uniform({0, m, 0, 77});
  const auto truth = reality::play(arm, driveOf(model), references, 0.00025, kInterval, kEnd);

  MotionCommands commands;
  commands.kinds.assign(model.muscles.size(), CommandKind::kSetpoint);
  commands.times = {0.0};
  commands.values = Eigen::Map<const Eigen::VectorXd>(references.data(), std::ssize(references));
  std::vector<double> times;
  for (std::size_t i = 0; i < truth.size(); ++i) times.push_back(kInterval * static_cast<double>(i));
  return test::largestPerStep(model, commands, {}, times, steps, [&](const MotionTrack& track, std::size_t row) {
    return test::largestAngle(arm, test::configurationOf(arm, track.jointsAt(row)), truth[row]);
  });
}

TEST(MotionAgreement, TwoSecondsOfRandomArmsAgreeWithBodiesAndReactions) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    EXPECT_LT(toDegrees(largestDifferences(seed, {0.001})[0]), 0.05) << "arm " << seed;
  }
}

// The study behind docs/studies/simulation.md: what a step costs.
TEST(SlowMotionAgreement, FiftyRandomArms) {
  const std::vector<double> largest = test::studySteps({0.001, 0.0005, 0.00025, 0.000125}, largestDifferences);
  EXPECT_LE(largest[0], 0.05);
}

}  // namespace
}  // namespace simgap
