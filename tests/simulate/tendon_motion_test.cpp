// Arms of every kind of joint and tendon in motion: energy, and rests against the evaluator that knows no time.
#include <gtest/gtest.h>

#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/rollout.h"
#include "support/arms.h"
#include "support/many_kinds.h"

namespace simgap {
namespace {

ArmModel movingArm() { return readArm(YamlNode::parse(test::kManyKinds, "many.yaml")); }

/// Nothing that takes energy, and no joint reaches a limit: limits and couplings are met by impulses, which take some.
ArmModel lossless() {
  ArmModel model = movingArm();
  model.muscles.clear();
  for (Joint& joint : model.joints) {
    joint.coulomb_friction = joint.viscous_friction = 0.0;
    if (joint.hasAxis()) joint.lower_limit = -(joint.upper_limit = Joint::kUnlimited);
    joint.leader = -1;
    // The ball turns slowly enough for steps of a millisecond.
    joint.spring_stiffness *= 0.2;
  }
  for (PassiveTendon& tendon : model.tendons) {
    for (std::size_t p = 0; p < tendon.kind->parameters.size(); ++p) {
      if (tendon.kind->parameters[p].name == "damping") tendon.p[p] = 0.0;
    }
  }
  return model;
}

/// Largest change of the energy within 0.3 s, relative to the work of the weight over 10 cm. Later the end of a line
/// enters its surface, where lines jump (docs/tendons.md).
double tendonEnergyDrift(double step) {
  const ArmModel model = lossless();
  BulletArmOptions options;
  options.step = step;
  BulletArm arm(model, options);
  arm.setJointVelocity(0, {0.4, 0.0, 0.0});
  arm.setJointVelocity(1, {1.0, -2.0, 3.0});
  arm.setJointVelocity(2, {2.0, 0.0, 0.0});
  const double start = arm.mechanicalEnergy();
  double drift = 0.0;
  for (int i = 0; i * step < 0.3; ++i) {
    arm.stepMotion();
    drift = std::max(drift, std::abs(arm.mechanicalEnergy() - start));
  }
  double mass = 0.0;
  for (const Body& body : model.bodies) mass += massProperties(body).mass;
  return drift / (mass * 9.81 * 0.1);
}

// Slides, hinges with frames of their own, lines over surfaces and springs: a wrong term of any of them feeds energy
// in.
TEST(TendonMotion, ALosslessArmKeepsItsEnergyToSecondOrder) {
  const double coarse = tendonEnergyDrift(0.001), fine = tendonEnergyDrift(0.0005);
  EXPECT_LT(fine, 1e-3);
  EXPECT_GT(coarse / fine, 2.5);  // four, but for where a line begins to touch a surface
}

TEST(TendonMotion, ItsEnergyIsThePotentialOfTheEquilibriaWhereNothingMoves) {
  const ArmModel model = lossless();
  BulletArm arm(model, {});
  PotentialEnergy potential(model);
  double offset = 0.0;
  for (const double way : {-0.05, 0.0, 0.08}) {
    std::vector<JointPosition> joints(model.joints.size());
    for (std::size_t j = 0; j < joints.size(); ++j) {
      joints[j].angle = model.joints[j].slides() ? way : 5.0 * way;
      joints[j].rotation = Eigen::Quaterniond(expSo3({way, -2.0 * way, 3.0 * way}));
    }
    arm.setJointPositions(joints);
    potential.evaluate(joints);
    const double apart = arm.mechanicalEnergy() - potential.energy();
    if (way == -0.05) offset = apart;
    EXPECT_NEAR(apart, offset, 1e-9);
  }
}

// Dampers bring it to rest; the motors hold it where the commands of a voltage have wound them to.
TEST(TendonMotion, ComesToRestWhereTheEnergyIsLeast) {
  ArmModel model = movingArm();
  for (Joint& joint : model.joints) joint.coulomb_friction = 0.0;
  RolloutOptions options;
  Rollout rollout(model, options);
  MotionCommands commands;
  commands.kinds.assign(model.muscles.size(), CommandKind::kSetpoint);
  commands.times = {0.0};
  commands.values = Eigen::MatrixXd::Constant(std::ssize(model.muscles), 1, 6.0);
  MotionTrack track;
  const std::vector<double> times = {30.0};
  ASSERT_TRUE(rollout.run(commands, {}, times, track).finished);
  std::vector<double> shafts(model.muscles.size());
  for (std::size_t m = 0; m < shafts.size(); ++m) shafts[m] = track.shafts(static_cast<Eigen::Index>(m), 0);
  EquilibriumArm equilibrium(model);
  ASSERT_TRUE(equilibrium.solve(shafts).stable);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    EXPECT_LT(toDegrees(jointError(model.joints[j].type, track.joints[j], equilibrium.joints()[j])), 0.02)
        << model.joints[j].name;
  }
}

}  // namespace
}  // namespace simgap
