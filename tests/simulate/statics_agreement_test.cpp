// Where the simulated arm comes to rest against where its potential energy has a minimum: the judge knows no forces,
// lever arms or frames, and shares no code with the simulation. It is given the shaft angles the drives really reached,
// since they lock on the way to their references.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "reality/arm_statics.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "support/statics.h"

namespace simgap {
namespace {

// Without Coulomb friction many of the arms swing for minutes. Viscous friction moves no equilibrium: with ten times as
// much they come to rest, and below 1e-4 rad/s the slowest (0.8 N m s on 0.3 N m/rad) are 3e-4 rad = 0.015 deg from it.
constexpr double kMoreViscous = 10.0;
constexpr double kSlow = 1e-4;        // [rad/s]
constexpr double kAgreement = 0.1;    // [deg]
constexpr double kLimitReach = 1e-6;  // [rad], a joint this near its stop is held by it

struct Tally {
  int poses = 0, steady = 0, other_branch = 0;
  double largest = 0.0, sum = 0.0;  // [deg]
  void report(const char* name) const {
    std::cout << name << ": " << steady << " of " << poses << " poses steady, error mean " << sum / std::max(1, steady)
              << " deg, largest " << largest << " deg; " << other_branch
              << " on another branch than followed from rest\n";
  }
};

// One pose of an arm without Coulomb friction in its joints.
void compare(const reality::Arm& arm, BulletArm& simulated, std::uint64_t seed, std::uint64_t pose, Tally& tally) {
  const std::vector<double> references = reality::randomShafts(arm, 1000 * seed + pose);
  const PoseOutcome outcome = replayPose(simulated, references, test::patientProtocol(kSlow));
  ++tally.poses;
  if (outcome.status != PoseStatus::kSteady) {
    std::cout << "arm " << seed << ", pose " << pose << ": " << toString(outcome.status) << ", worst " << outcome.worst
              << " with " << outcome.worst_value << "\n";
    return;
  }
  ++tally.steady;
  const reality::Configuration reached = test::configurationOf(arm, outcome.joints);
  const reality::Equilibrium expected = reality::minimise(arm, outcome.shafts, reached);
  ASSERT_TRUE(expected.converged) << "arm " << seed << ", pose " << pose;
  const double error = toDegrees(test::largestAngle(arm, reached, expected.configuration));
  EXPECT_LE(error, kAgreement) << "arm " << seed << ", pose " << pose << ", stiffness " << expected.stiffness;
  tally.largest = std::max(tally.largest, error);
  tally.sum += error;
  // The equilibrium evaluator is judged by the same physics engine, at the shaft angles that were reached.
  EquilibriumArm equilibrium(test::modelOf(arm, false));
  ASSERT_TRUE(equilibrium.solveFrom(outcome.joints, outcome.shafts).stable) << "arm " << seed << ", pose " << pose;
  const reality::Configuration minimum = test::configurationOf(arm, equilibrium.joints());
  EXPECT_LE(toDegrees(test::largestAngle(arm, reached, minimum)), kAgreement) << "arm " << seed << ", pose " << pose;
  const reality::Equilibrium followed = reality::followFromRest(arm, outcome.shafts);
  tally.other_branch += toDegrees(test::largestAngle(arm, expected.configuration, followed.configuration)) > 1.0;
}

void compareArms(std::uint64_t first, std::uint64_t last, int poses, const char* name) {
  Tally tally;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    reality::Arm arm = seed == 0 ? reality::referenceArm() : reality::randomArm(seed);
    for (reality::Link& link : arm.links) link.viscous *= kMoreViscous;
    BulletArm simulated(test::modelOf(arm, false), {});
    for (int pose = 0; pose < poses; ++pose) compare(arm, simulated, seed, pose, tally);
  }
  tally.report(name);
  EXPECT_GE(tally.steady, 0.95 * tally.poses);
}

// What is left of gravity and muscles where the joint stops have taken their part: friction must hold it. [N m]
double unheldTorque(const reality::Link& link, const Eigen::VectorXd& torque, double angle) {
  if (link.joint == reality::Joint::kRevolute) {
    if (angle < link.lower + kLimitReach) return std::max(0.0, torque[0]);
    if (angle > link.upper - kLimitReach) return std::max(0.0, -torque[0]);
  }
  return torque.norm();
}

struct Friction {
  int poses = 0, steady = 0, at_stop = 0;
  double largest_share = 0.0;  // of the Coulomb torque
  double moved = 0.0;          // [deg], mean distance to the minimum
};

void checkFriction(const reality::Arm& arm, BulletArm& simulated, const std::vector<double>& references,
                   Friction& tally) {
  // 1e-6 rad/s leaves 1e-7 N m of viscous torque.
  const PoseOutcome outcome = replayPose(simulated, references, test::patientProtocol(1e-6));
  ++tally.poses;
  if (outcome.status != PoseStatus::kSteady) return;
  ++tally.steady;
  const reality::Configuration reached = test::configurationOf(arm, outcome.joints);
  const reality::JointTorques torques = reality::jointTorque(arm, outcome.shafts, reached);
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const double unheld = unheldTorque(arm.links[i], torques[i], reached[i].angle);
    EXPECT_LE(unheld, 1.01 * arm.links[i].coulomb + 1e-6) << reality::jointName(static_cast<int>(i));
    tally.largest_share = std::max(tally.largest_share, unheld / arm.links[i].coulomb);
    tally.at_stop += unheld < torques[i].norm();
  }
  const reality::Equilibrium minimum = reality::minimise(arm, outcome.shafts, reached);
  tally.moved += toDegrees(test::largestAngle(arm, reached, minimum.configuration));
}

void checkFrictionOfArms(std::uint64_t first, std::uint64_t last, int poses, const char* name) {
  Friction tally;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    SCOPED_TRACE("arm " + std::to_string(seed));
    const reality::Arm arm = seed == 0 ? reality::referenceArm() : reality::randomArm(seed);
    BulletArm simulated(test::modelOf(arm, true), {});
    for (int pose = 0; pose < poses; ++pose) {
      checkFriction(arm, simulated, reality::randomShafts(arm, 1000 * seed + pose), tally);
    }
  }
  std::cout << name << ": " << tally.steady << " of " << tally.poses << " poses steady, largest torque "
            << tally.largest_share << " of the joint's friction, " << tally.at_stop << " joints at a stop, "
            << tally.moved / std::max(1, tally.steady) << " deg from the minimum on average\n";
  EXPECT_GE(tally.steady, 0.95 * tally.poses);
}

TEST(StaticsAgreement, ArmsRestInAMinimumOfTheirEnergy) { compareArms(0, 40, 3, "statics"); }

TEST(StaticsAgreement, FrictionHoldsNoMoreThanItCan) { checkFrictionOfArms(0, 40, 3, "friction"); }

TEST(SlowStaticsAgreement, ArmsRestInAMinimumOfTheirEnergy) { compareArms(1001, 1200, 4, "statics"); }

TEST(SlowStaticsAgreement, FrictionHoldsNoMoreThanItCan) { checkFrictionOfArms(1001, 1200, 4, "friction"); }

}  // namespace
}  // namespace simgap
