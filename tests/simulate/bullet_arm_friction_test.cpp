// Joint friction and joint limits, one joint at a time: every expected value is a line of arithmetic.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simgap/simulate/bullet_arm.h"
#include "support/arms.h"

namespace simgap {
namespace {

using Eigen::Vector3d;

constexpr double kFrictionStep = 0.002;

void runSticking(BulletArm& arm, double duration) {
  for (long i = std::lround(duration / kFrictionStep); i > 0; --i) arm.step();
}

void placeHinge(BulletArm& arm, double angle) { arm.setJointPositions(std::vector{test::hingeAt(angle)}); }

// A hinge in which 2 kg swing, without weight.
ArmModel flywheel(double coulomb, double viscous) {
  ArmModel model = test::pendulum();
  model.gravity.setZero();
  model.joints[0].coulomb_friction = coulomb;
  model.joints[0].viscous_friction = viscous;
  return model;
}

// A solid ball about a ball joint in its centre: 0.4 * 2 kg * (0.1 m)^2 = 8 g m^2 about every axis.
ArmModel ball(double coulomb, double viscous) {
  ArmModel model = test::torso();
  model.gravity.setZero();
  Joint& joint =
      test::addLink(model, 0, JointType::kSpherical, Vector3d::Zero(), {test::sphere(2.0, Vector3d::Zero(), 0.1)});
  joint.coulomb_friction = coulomb;
  joint.viscous_friction = viscous;
  return model;
}
constexpr double kBallInertia = 0.008;

// ------------------------------------------------------------------------------------------------ Coulomb

TEST(CoulombFriction, HoldsAHingeUpToItsTorqueAndNotBeyond) {
  ArmModel model = test::pendulum();
  model.joints[0].coulomb_friction = 1.0;
  BulletArm arm(model, {});
  const double limit = std::asin(1.0 / (test::kPendulumMass * test::kGravity * test::kPendulumLength));
  for (const double sign : {1.0, -1.0}) {
    placeHinge(arm, sign * limit * (1.0 - 1e-6));
    runSticking(arm, 2.0);
    EXPECT_NEAR(arm.jointPosition(0).angle, sign * limit * (1.0 - 1e-6), 1e-14) << "rounding of 1000 steps";
    placeHinge(arm, sign * limit * (1.0 + 1e-6));
    runSticking(arm, 0.2);
    EXPECT_GT(arm.jointSpeed(0), 1e-7);
  }
}

TEST(CoulombFriction, HoldsABallUpToItsTorqueInEveryDirection) {
  // The weight of a lopsided box turns the joint about m p x g; friction clamped axis by axis would hold up to
  // sqrt(3) times its torque, or sqrt(2) in a plane. Speeds differ by orders: 1e-6 of the torque gives 4e-7 rad/s.
  std::mt19937 random(1);
  const double torque = 0.1;
  for (int i = 0; i < 200; ++i) {
    const Vector3d p = 0.15 * test::randomDirection(random);
    const Vector3d down = p.cross(test::randomDirection(random)).normalized();
    for (const double excess : {-1e-6, 1e-6}) {
      ArmModel model = test::torso();
      model.gravity = down * (torque * (1.0 + excess) / (2.0 * p.norm()));
      test::addLink(model, 0, JointType::kSpherical, Vector3d::Zero(), {test::box(2.0, p, {0.05, 0.1, 0.15})})
          .coulomb_friction = torque;
      BulletArm arm(model, {});
      runSticking(arm, 0.2);
      if (excess < 0.0) {
        EXPECT_LT(arm.jointSpeed(0), 1e-12) << "torque about " << p.cross(down).transpose();
      } else {
        EXPECT_GT(arm.jointSpeed(0), 1e-8) << "torque about " << p.cross(down).transpose();
      }
    }
  }
}

TEST(CoulombFriction, StopsASpinAfterInertiaTimesSpeedOverTorque) {
  // w0 = 2 rad/s: the hinge stops after I w0 / tau = 0.9 s, at constant deceleration.
  BulletArm hinge(flywheel(0.1, 0.0), {});
  hinge.setJointVelocity(0, {2.0, 0.0, 0.0});
  BulletArm round(ball(0.02, 0.0), {});
  round.setJointVelocity(0, 2.0 * Vector3d(0.48, -0.6, 0.64));
  const double hinge_rate = 0.1 / test::kPendulumInertia;
  const double ball_rate = 0.02 / kBallInertia;
  for (int i = 1; i <= 500; ++i) {
    hinge.step();
    round.step();
    ASSERT_NEAR(hinge.jointSpeed(0), std::max(0.0, 2.0 - hinge_rate * i * kFrictionStep), 1e-12) << "step " << i;
    ASSERT_NEAR(round.jointSpeed(0), std::max(0.0, 2.0 - ball_rate * i * kFrictionStep), 1e-12) << "step " << i;
  }
  // Turned by w0^2 / (2 rate) in the limit of short steps, by half a step of w0 less with semi-implicit Euler.
  const double turned = 2.0 * 2.0 / (2.0 * ball_rate) - 0.5 * 2.0 * kFrictionStep;
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(turned, Vector3d(0.48, -0.6, 0.64)));
  EXPECT_LT(geodesicAngle(round.jointPosition(0).rotation, expected), 0.5 * ball_rate * kFrictionStep * kFrictionStep);
}

TEST(CoulombFriction, OfASlippingBallIsItsTorqueAndOpposesTheSlip) {
  // A box about a ball joint in its centre; the impulse is what a step with friction lacks to one without.
  ArmModel model = ball(0.05, 0.0);
  model.bodies[1].parts = {test::box(2.0, Vector3d::Zero(), {0.05, 0.2, 0.4})};
  ArmModel smooth = model;
  smooth.joints[0].coulomb_friction = 0.0;
  const Vector3d inertia = 2.0 / 12.0 * Vector3d(0.04 + 0.16, 0.0025 + 0.16, 0.0025 + 0.04);
  BulletArm arm(model, {});
  BulletArm free(smooth, {});
  std::mt19937 random(2);
  const auto velocityAfter = [&](BulletArm& which, const Vector3d& velocity) {
    const std::vector<JointPosition> start(1);
    which.setJointPositions(start);
    which.setJointVelocity(0, velocity);
    which.step();
    return test::velocitiesBetween(model, start, std::vector<JointPosition>{which.jointPosition(0)}, kFrictionStep)[0];
  };
  for (int i = 0; i < 200; ++i) {
    const Vector3d direction = test::randomDirection(random);
    const Vector3d velocity = test::uniform(random, 0.05, 3.0) * direction;
    const Vector3d slip = velocityAfter(arm, velocity);
    const Vector3d torque = inertia.cwiseProduct(slip - velocityAfter(free, velocity)) / kFrictionStep;
    // Velocities come from angles of 1e-4 rad and more, to 1e-16 / 2 ms: 1e-13 rad/s, over 2 ms and 0.03 kg m^2.
    EXPECT_NEAR(torque.norm(), 0.05, 1e-10);
    EXPECT_NEAR(torque.normalized().dot(slip.normalized()), -1.0, 1e-8);
  }
}

TEST(CoulombFriction, StopsTwoJointsAtOnce) {
  // Momenta are below 1 N m s, a step of friction takes 10.
  ArmModel model = test::pendulum(JointType::kSpherical);
  test::addLink(model, 1, JointType::kRevolute, {0.0, 0.0, -0.3}, model.bodies[1].parts);
  model.joints[0].coulomb_friction = model.joints[1].coulomb_friction = 5000.0;
  BulletArm arm(model, {});
  arm.setJointVelocity(0, {1.0, 2.0, -1.0});
  arm.setJointVelocity(1, {-3.0, 0.0, 0.0});
  // Sweeps over coupled joints end after 100 or at 1e-11 rad/s; the next step begins where the last one ended.
  for (int i = 0; i < 2; ++i) arm.step();
  EXPECT_LT(arm.jointSpeed(0), 1e-7);
  arm.step();
  EXPECT_LT(arm.jointSpeed(0), 1e-10);
  EXPECT_LT(arm.jointSpeed(1), 1e-10);
}

// ------------------------------------------------------------------------------------------------ viscous

TEST(ViscousFriction, DecaysAtTheRateOfImplicitEuler) {
  // I w' = -c w with the new velocity on the right: w_n = w_0 / (1 + c dt / I)^n, exp(-c t / I) for short steps.
  BulletArm hinge(flywheel(0.0, 0.05), {});
  hinge.setJointVelocity(0, {3.0, 0.0, 0.0});
  BulletArm round(ball(0.0, 0.01), {});
  round.setJointVelocity(0, {1.0, -2.0, 2.0});
  const double hinge_factor = 1.0 / (1.0 + 0.05 * kFrictionStep / test::kPendulumInertia);
  const double ball_factor = 1.0 / (1.0 + 0.01 * kFrictionStep / kBallInertia);
  for (int i = 1; i <= 500; ++i) {
    hinge.step();
    round.step();
    ASSERT_NEAR(hinge.jointSpeed(0), 3.0 * std::pow(hinge_factor, i), 1e-12);
    ASSERT_NEAR(round.jointSpeed(0), 3.0 * std::pow(ball_factor, i), 1e-12);
  }
  EXPECT_NEAR(hinge.jointSpeed(0), 3.0 * std::exp(-0.05 / test::kPendulumInertia), 2e-3);
}

TEST(ViscousFriction, IsStableForAnyInertia) {
  // 5 N m s on 1e-7 kg m^2 has a time constant of 20 ns; explicit Euler at 2 ms would blow up at once.
  ArmModel model = test::torso();
  test::addLink(model, 0, JointType::kRevolute, Vector3d::Zero(), {test::sphere(1e-3, {0, 0, -0.01}, 0.005)})
      .viscous_friction = 5.0;
  BulletArm arm(model, {});
  arm.setJointVelocity(0, {100.0, 0.0, 0.0});
  arm.step();
  EXPECT_LT(arm.jointSpeed(0), 1e-2);
  runSticking(arm, 1.0);
  EXPECT_TRUE(arm.isFinite());
}

TEST(JointFriction, SlidesDownAtTheSpeedWhereTorquesBalance) {
  // A constant weight torque of m g l on a slow hinge: c w = m g l sin(q) - tau_max.
  ArmModel model = test::pendulum();
  model.joints[0].coulomb_friction = 1.0;
  model.joints[0].viscous_friction = 200.0;
  BulletArm arm(model, {});
  placeHinge(arm, 0.5 * M_PI);
  runSticking(arm, 0.1);
  const double weight = test::kPendulumMass * test::kGravity * test::kPendulumLength;
  // It has turned by 1 mrad (1 - cos: 5e-7), and slows down with it over 0.2 ms.
  EXPECT_NEAR(arm.jointSpeed(0), (weight - 1.0) / 200.0, 1e-7);
}

// ------------------------------------------------------------------------------------------------ limits

TEST(JointLimit, StopsAFallWithoutPenetrationOrBounce) {
  for (const double sign : {1.0, -1.0}) {
    ArmModel model = test::pendulum();
    (sign > 0.0 ? model.joints[0].lower_limit : model.joints[0].upper_limit) = sign * 0.2;
    BulletArm arm(model, {});
    BulletArm free(test::pendulum(), {});
    placeHinge(arm, sign * 1.2);
    placeHinge(free, sign * 1.2);
    bool landed = false;
    for (int i = 0; i < 1000; ++i) {
      arm.step();
      free.step();
      ASSERT_TRUE(landed || sign * free.jointPosition(0).angle < 0.2 ||
                  arm.jointPosition(0).angle == free.jointPosition(0).angle)
          << "the stop acted from afar";
      const double above = sign * arm.jointPosition(0).angle - 0.2;
      ASSERT_GE(above, -1e-9);
      landed = landed || above < 1e-9;
      ASSERT_TRUE(!landed || above <= 1e-9) << "bounced to " << above;
    }
    EXPECT_TRUE(landed);
    EXPECT_LT(arm.jointSpeed(0), 1e-12);
  }
}

TEST(JointLimit, LetsGoOfAJointThatIsPulledAway) {
  ArmModel model = test::pendulum();
  model.joints[0].lower_limit = 0.2;
  model.joints[0].upper_limit = 1.0;
  model.gravity = -model.gravity;
  BulletArm arm(model, {});
  placeHinge(arm, 0.2);
  arm.step();
  // Nothing but the weight acts: I w = m g l sin(0.2) dt.
  const double weight = test::kPendulumMass * test::kGravity * test::kPendulumLength * std::sin(0.2);
  EXPECT_NEAR(arm.jointSpeed(0), weight / test::kPendulumInertia * kFrictionStep, 1e-12);
  runSticking(arm, 2.0);
  EXPECT_NEAR(arm.jointPosition(0).angle, 1.0, 1e-9) << "the other stop";
}

TEST(JointLimit, FixesAJointWhoseLimitsAreTheSame) {
  ArmModel model = test::pendulum();
  model.joints[0].lower_limit = model.joints[0].upper_limit = 0.7;
  BulletArm arm(model, {});
  runSticking(arm, 1.0);
  EXPECT_NEAR(arm.jointPosition(0).angle, 0.7, 1e-12);
}

TEST(JointLimit, AndFrictionSettleTogether) {
  // An arm of three joints whose hinges are pressed on their stops by its weight while friction holds the rest.
  ArmModel model = test::pendulum(JointType::kSpherical);
  for (int parent : {1, 2}) {
    Joint& joint = test::addLink(model, parent, JointType::kRevolute, {0.0, 0.0, -0.3}, model.bodies[1].parts);
    joint.lower_limit = 0.25;
    joint.upper_limit = 1.0;
  }
  for (Joint& joint : model.joints) {
    joint.coulomb_friction = 0.1;
    joint.viscous_friction = 1.0;
  }
  BulletArm arm(model, {});
  runSticking(arm, 40.0);
  for (int i = 0; i < 500; ++i) {
    arm.step();
    for (std::size_t j = 0; j < 3; ++j) ASSERT_LT(arm.jointSpeed(j), 1e-9) << "joint " << j;
  }
  EXPECT_NEAR(arm.jointPosition(1).angle, 0.25, 1e-9);
  EXPECT_NEAR(arm.jointPosition(2).angle, 0.25, 1e-9);
}

}  // namespace
}  // namespace simgap
