// Muscles on the arm, its sensors, and what a reset or another model leaves behind: nothing.
#include "simgap/simulate/bullet_arm.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simgap/simulate/pose_protocol.h"
#include "support/arms.h"
#include "support/statics.h"

namespace simgap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kStep = 0.002;

void run(BulletArm& arm, double duration) {
  for (long i = std::lround(duration / kStep); i > 0; --i) arm.step();
}

// A gearbox that no line can turn: the shaft stays at 0 and the muscle is a spring.
void lockDrive(Muscle& muscle) { muscle.gearbox.coulomb_friction = 1e6; }

// ------------------------------------------------------------------------------------------------ bodies

TEST(MassProperties, FollowTheParallelAxisTheorem) {
  // A rod of 3 kg lying along x and a cube of 1 kg, worked out by hand: the centre is a quarter of the way to the cube.
  Body body{"body",
            false,
            {test::cylinder(3.0, {0, 0, 0}, Vector3d::UnitX(), 0.02, 0.3),
             test::box(1.0, {0.0, 0.08, -0.04}, {0.06, 0.06, 0.06})},
            {}};
  const MassProperties found = massProperties(body);
  EXPECT_DOUBLE_EQ(found.mass, 4.0);
  EXPECT_LT((found.centre_of_mass - Vector3d(0.0, 0.02, -0.01)).norm(), 1e-16);
  // Own inertias: rod 1/2 m r^2 = 6e-4 along x, m (3 r^2 + l^2) / 12 = 0.0228 across; cube m a^2 / 6 = 6e-4.
  // Steiner: 3 kg at (0, -0.02, 0.01) and 1 kg at (0, 0.06, -0.03).
  const double xx = 6e-4 + 6e-4 + 3.0 * 5e-4 + 1.0 * 45e-4;
  const double yy = 0.0228 + 6e-4 + 3.0 * 1e-4 + 1.0 * 9e-4;
  const double zz = 0.0228 + 6e-4 + 3.0 * 4e-4 + 1.0 * 36e-4;
  const double yz = -(3.0 * -0.02 * 0.01 + 1.0 * 0.06 * -0.03);
  Matrix3d expected;
  expected << xx, 0, 0, 0, yy, yz, 0, yz, zz;
  EXPECT_LT((found.inertia - expected).norm(), 1e-15) << found.inertia;
}

TEST(BulletArm, TakesTheInertiaOfACompoundAboutItsPivot) {
  // From rest one step under gravity g about x: I w = m g y_c dt, I with the pivot's Steiner term by hand.
  ArmModel model = test::torso();
  test::addLink(model, 0, JointType::kRevolute, Vector3d::Zero(),
                {test::cylinder(3.0, {0, 0.1, 0}, Vector3d::UnitX(), 0.02, 0.3),
                 test::box(1.0, {0.0, 0.18, -0.04}, {0.06, 0.06, 0.06})});
  BulletArm arm(model, {});
  arm.setJointPositions(std::vector<JointPosition>(1));
  arm.step();
  const double inertia = 6e-4 + 6e-4 + 3.0 * 0.1 * 0.1 + 1.0 * (0.18 * 0.18 + 0.04 * 0.04);
  const double torque = test::kGravity * (3.0 * 0.1 + 1.0 * 0.18);
  EXPECT_NEAR(arm.jointSpeed(0), torque / inertia * kStep, 1e-13);
  EXPECT_LT(arm.jointPosition(0).angle, 0.0) << "falls towards -z, a negative turn about x";
}

// ------------------------------------------------------------------------------------------------ muscles

TEST(BulletArm, OneMuscleHoldsAHingeWhereThePaperSays) {
  // Cord without length from a on +y to b down the link: E = -m g l cos q - k a b sin q: tan q = k a b / (m g l).
  ArmModel model = test::pendulum();
  model.joints[0].viscous_friction = 0.5;
  lockDrive(test::addMuscle(model, {0, {0, 0.02, 0}}, {1, {0, 0, -0.12}}, 0.0));
  BulletArm arm(model, {});
  run(arm, 10.0);
  const double weight = test::kPendulumMass * test::kGravity * test::kPendulumLength;
  // 0.5 N m s over 3.6 N m/rad: 70 time constants.
  EXPECT_NEAR(arm.jointPosition(0).angle, std::atan2(900.0 * 0.02 * 0.12, weight), 1e-12);
  EXPECT_EQ(arm.shaftAngle(0), 0.0);
}

// Two hinges about x, 0.3 m apart, a mass below each; a muscle from the torso to the second link crosses both.
struct TwoLinks {
  double q1 = 0.4, q2 = 0.5;
  double first_mass = 1.2, second_mass = 0.7, first_depth = 0.12, second_depth = 0.1, length = 0.3;
  Vector3d from{0.0, 0.06, 0.02}, to{0.0, 0.03, -0.06};

  ArmModel model() const {
    ArmModel model = test::torso();
    test::addLink(model, 0, JointType::kRevolute, {0, 0, 0}, {test::sphere(first_mass, {0, 0, -first_depth}, 0.03)});
    test::addLink(model, 1, JointType::kRevolute, {0, 0, -length},
                  {test::sphere(second_mass, {0, 0, -second_depth}, 0.03)});
    lockDrive(test::addMuscle(model, {0, from}, {2, to}, 0.0));
    return model;
  }

  // M a = tau of the textbook's double pendulum at rest, with the muscle's lever arms dL/dq.
  Eigen::Vector2d acceleration(double stiffness) const {
    const double own1 = 0.4 * first_mass * 0.03 * 0.03;
    const double own2 = 0.4 * second_mass * 0.03 * 0.03;
    const double coupling = second_mass * length * second_depth * std::cos(q2);
    const double m22 = own2 + second_mass * second_depth * second_depth;
    const double m11 =
        own1 + first_mass * first_depth * first_depth + second_mass * length * length + m22 + 2 * coupling;
    Eigen::Matrix2d mass;
    mass << m11, m22 + coupling, m22 + coupling, m22;
    const double w2 = -test::kGravity * second_mass * second_depth * std::sin(q1 + q2);
    const double w1 = -test::kGravity * (first_mass * first_depth + second_mass * length) * std::sin(q1) + w2;

    const Vector3d elbow(0.0, length * std::sin(q1), -length * std::cos(q1));
    const Vector3d end = elbow + Eigen::AngleAxisd(q1 + q2, Vector3d::UnitX()) * to;
    const Vector3d pull = -stiffness * (end - from);
    const Eigen::Vector2d muscle(Vector3d::UnitX().cross(end).dot(pull),
                                 Vector3d::UnitX().cross(end - elbow).dot(pull));
    return mass.inverse() * (Eigen::Vector2d(w1, w2) + muscle);
  }
};

TEST(BulletArm, BiarticularMuscleTurnsBothJoints) {
  const TwoLinks arm_on_paper;
  const ArmModel model = arm_on_paper.model();
  BulletArm arm(model, {});
  arm.setJointPositions(std::vector{test::hingeAt(arm_on_paper.q1), test::hingeAt(arm_on_paper.q2)});
  arm.step();
  const Eigen::Vector2d expected = arm_on_paper.acceleration(900.0);
  // The angle turned in a step is dt^2 a = 1e-4 rad, known to 1e-16.
  EXPECT_NEAR((arm.jointPosition(0).angle - arm_on_paper.q1) / (kStep * kStep), expected[0], 1e-9);
  EXPECT_NEAR((arm.jointPosition(1).angle - arm_on_paper.q2) / (kStep * kStep), expected[1], 1e-9);
  const Eigen::Vector2d without = arm_on_paper.acceleration(0.0);
  EXPECT_GT((expected - without).cwiseAbs().minCoeff(), 1.0) << "the muscle matters to both";
}

TEST(BulletArm, SlackMusclePullsNothing) {
  ArmModel model = test::pendulum(JointType::kSpherical);
  BulletArm without(model, {});
  test::addMuscle(model, {0, {0, 0.05, 0}}, {1, {0, 0, -0.12}}, 1.0);
  BulletArm with(model, {});
  for (BulletArm* arm : {&with, &without}) arm->setJointVelocity(0, {2.0, 1.0, -1.0});
  for (int i = 0; i < 500; ++i) {
    with.step();
    without.step();
    ASSERT_EQ(with.force(0), 0.0);
    ASSERT_LT(with.cordExpansion(0), 0.0);
  }
  EXPECT_EQ(with.jointPosition(0).rotation.coeffs(), without.jointPosition(0).rotation.coeffs());
}

TEST(BulletArm, CordNeverPushesWhenItsEndsApproachFast) {
  // Taut by 1 mm (0.9 N) while its ends approach: at 10 rad/s the damper alone would push with 15 * 0.5 N.
  ArmModel model = test::pendulum();
  lockDrive(test::addMuscle(model, {0, {0, 0.05, 0}}, {1, {0, 0, -0.12}}, 0.129));
  BulletArm arm(model, {});
  arm.setJointPositions(std::vector<JointPosition>(1));
  arm.setJointVelocity(0, {10.0, 0.0, 0.0});
  arm.step();
  EXPECT_NEAR(arm.cordExpansion(0) * 0.08, 0.001, 1e-12);
  EXPECT_EQ(arm.force(0), 0.0);
  arm.reset();
  arm.setJointPositions(std::vector<JointPosition>(1));
  arm.setJointVelocity(0, {-10.0, 0.0, 0.0});
  arm.step();
  // L = 0.13 (5-12-13): dL/dq = -a b / L.
  EXPECT_NEAR(arm.force(0), 0.9 + 15.0 * 10.0 * 0.05 * 0.12 / 0.13, 1e-10);
}

// The joints moved on for `duration` with constant velocities.
std::vector<JointPosition> movedOn(const ArmModel& model, std::vector<JointPosition> joints,
                                   const std::vector<Vector3d>& velocities, double duration) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    joints[j].angle += velocities[j].x() * duration;
    if (model.joints[j].type != JointType::kSpherical) continue;
    const double turn = velocities[j].norm() * duration;
    joints[j].rotation = joints[j].rotation * Eigen::AngleAxisd(turn, velocities[j].normalized());
  }
  return joints;
}

TEST(BulletArm, CordDampsTheRateAtWhichItsLengthReallyChanges) {
  // Chains and trees with pivots beside the bodies' origins; the rate is a central difference of the lengths.
  std::mt19937 random(5);
  int taut = 0;
  for (const std::uint64_t seed : {3, 5, 8, 15}) {
    ArmModel model = test::modelOf(reality::randomArm(seed), true);
    for (Muscle& muscle : model.muscles) muscle.kite_line_length -= 0.05;
    std::vector<JointPosition> joints = startPosition(model);
    std::vector<Vector3d> velocities;
    for (JointPosition& joint : joints) {
      joint.rotation = test::ballAt(0.4, test::randomDirection(random)).rotation;
      velocities.push_back(0.8 * test::randomDirection(random));
    }
    BulletArm arm(model, {});
    arm.setJointPositions(joints);
    for (std::size_t j = 0; j < joints.size(); ++j) arm.setJointVelocity(j, velocities[j]);
    arm.step();
    const double h = 1e-5;  // truncation h^2 and rounding 1e-16 / h are both near 1e-10 m/s
    for (std::size_t m = 0; m < model.muscles.size(); ++m) {
      const Muscle& muscle = model.muscles[m];
      const auto lengthAfter = [&](double duration) {
        return muscleLength(muscle, bodiesInWorld(model, movedOn(model, joints, velocities, duration)));
      };
      const double rate = (lengthAfter(h) - lengthAfter(-h)) / (2.0 * h);
      EXPECT_NEAR(arm.force(m), muscle.shock_cord.force(lengthAfter(0.0) - muscle.kite_line_length, rate), 1e-7)
          << "arm " << seed << ", " << muscle.name;
      taut += arm.force(m) > 1.0;
    }
  }
  EXPECT_GT(taut, 10);
}

TEST(BulletArm, CordIsDampedWhileTheSpindleWindsItUp) {
  // A joint that does not move and a cord of almost no stiffness: F = D r w of the shaft.
  ArmModel model = test::pendulum();
  model.joints[0].lower_limit = model.joints[0].upper_limit = 0.3;
  Muscle& muscle = test::addMuscle(model, {0, {0, 0.05, 0}}, {1, {0, 0, -0.12}}, 0.05);
  muscle.shock_cord.stiffness = 1e-9;
  BulletArm arm(model, {});
  arm.setShaftReferences(std::vector<double>{50.0});
  run(arm, 1.0);
  const double before = arm.shaftAngle(0);
  arm.step();
  EXPECT_GT(arm.shaftAngle(0), before + 14.0 * kStep);
  EXPECT_NEAR(arm.force(0), 15.0 * 0.006 * (arm.shaftAngle(0) - before) / kStep, 1e-6) << "at constant speed";
}

// ------------------------------------------------------------------------------------------------ sensors

TEST(Sensors, ReadTheirEquationsAtRest) {
  ArmModel model = test::pendulum();
  model.joints[0].viscous_friction = 0.5;
  Muscle& muscle = test::addMuscle(model, {0, {0, 0.05, 0.0}}, {1, {0, 0, -0.12}}, 0.11);
  muscle.potentiometer_initial = 2.5;
  BulletArm arm(model, {});
  EXPECT_EQ(arm.potentiometer(0), 2.5);
  const double reference = 3.0;
  arm.setShaftReferences(std::vector<double>{reference});
  run(arm, 8.0);
  ASSERT_LT(arm.jointSpeed(0), 1e-10);
  const double shaft = arm.shaftAngle(0);
  EXPECT_NEAR(shaft, reference, 0.05);
  EXPECT_NEAR(arm.potentiometer(0), 2.5 - shaft, 1e-13);
  const double line = muscle.kite_line_length + muscle.spindle_radius * (arm.potentiometer(0) - 2.5);  // eq. (13)
  EXPECT_NEAR(line, muscle.kiteLineLength(shaft), 1e-15);

  const std::vector<JointPosition> joints = {arm.jointPosition(0)};
  const double expansion = muscleLength(muscle, bodiesInWorld(model, joints)) - line - 0.08;
  EXPECT_GT(expansion, 0.005);
  EXPECT_NEAR(arm.cordExpansion(0), expansion / 0.08, 1e-9);
  EXPECT_NEAR(arm.force(0), 900.0 * expansion, 1e-6) << "speeds below 1e-10 rad/s, 15 N s/m";
  EXPECT_NEAR(arm.shaftError(0), reference - shaft, 0.0);
  EXPECT_NEAR(arm.current(0), 50.0 * (reference - shaft) / 0.8, 1e-9) << "K_p times error over resistance";
}

TEST(Sensors, PotentiometerTurnsOnceForEveryTurnOfTheSpindle) {
  ArmModel model = test::pendulum();
  test::addMuscle(model, {0, {0, 0.05, 0}}, {1, {0, 0, -0.12}}, 1.0).potentiometer_initial = -1.0;
  BulletArm arm(model, {});
  arm.setShaftReferences(std::vector<double>{2.0 * M_PI});
  run(arm, 3.0);
  EXPECT_NEAR(arm.potentiometer(0), -1.0 - 2.0 * M_PI, 0.02);
}

// ------------------------------------------------------------------------------------------------ reset, models

void expectSameBits(const PoseOutcome& a, const PoseOutcome& b) {
  ASSERT_EQ(a.status, b.status);
  EXPECT_EQ(a.duration, b.duration);
  EXPECT_EQ(a.shafts, b.shafts);
  EXPECT_EQ(a.cord_expansion, b.cord_expansion);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t j = 0; j < a.joints.size(); ++j) {
    EXPECT_EQ(a.joints[j].angle, b.joints[j].angle);
    EXPECT_EQ(a.joints[j].rotation.coeffs(), b.joints[j].rotation.coeffs());
  }
}

PoseOutcome fresh(const ArmModel& model, const std::vector<double>& shafts) {
  BulletArm arm(model, {});
  return replayPose(arm, shafts, {});
}

const std::vector<double> kOnePose = {0.5, 2.0, 0.5, -1.0, 1.0, 2.0, 1.5, -1.0, 1.0, 2.5, 0.5};
const std::vector<double> kOtherPose = {2.0, -1.0, 1.5, 3.0, -1.0, 0.5, 2.0, 2.5, 0.0, -1.0, 3.0};

TEST(BulletArm, PoseDoesNotDependOnWhatWasBefore) {
  const ArmModel model = test::exampleArm();
  ArmModel heavier = model;
  heavier.bodies[1].parts[0].mass *= 1.3;
  heavier.joints[1].coulomb_friction = 0.2;
  heavier.muscles[3].shock_cord.stiffness = 500.0;
  ArmModel runaway = model;
  runaway.muscles[0].shock_cord.stiffness = 1e12;
  const PoseOutcome expected = fresh(model, kOnePose);
  ASSERT_EQ(expected.status, PoseStatus::kSteady);

  BulletArm arm(model, {});
  replayPose(arm, kOtherPose, {});
  expectSameBits(replayPose(arm, kOnePose, {}), expected);
  for (const ArmModel& other : {heavier, test::exampleArm("arm-elbow"), runaway}) {
    arm.setModel(other);
    replayPose(arm, kOtherPose, {});
    arm.setModel(model);
    expectSameBits(replayPose(arm, kOnePose, {}), expected);
  }
}

TEST(BulletArm, ARunawayLeavesNothingBehindWhenTheWorldIsKept) {
  const ArmModel model = test::exampleArm();
  const PoseOutcome expected = fresh(model, kOnePose);
  ArmModel runaway = model;  // same bodies and joints: no rebuild
  for (Muscle& muscle : runaway.muscles) muscle.shock_cord.stiffness = 1e12;
  BulletArm arm(runaway, {});
  ASSERT_EQ(replayPose(arm, kOtherPose, {}).status, PoseStatus::kNotFinite);
  arm.setModel(model);
  expectSameBits(replayPose(arm, kOnePose, {}), expected);
}

TEST(BulletArm, TakesEveryChangeOfAModel) {
  const ArmModel model = test::exampleArm();
  std::vector<ArmModel> changed(9, model);
  changed[0].bodies[2].parts[1].mass *= 1.5;
  changed[1].joints[1].lower_limit = 0.9;
  changed[2].joints[0].coulomb_friction = 0.0;
  changed[3].gravity.z() = -5.0;
  changed[4].joints[1].parent_position.x() += 0.01;
  changed[5].muscles.erase(changed[5].muscles.begin() + 2);
  changed[6].muscles[8].spindle_radius = 0.009;
  changed[7].muscles[4].motor.torque_constant *= 0.7;
  changed[8].muscles[1].attachments[1].point.y() += 0.01;
  const PoseOutcome before = fresh(model, kOnePose);
  for (const ArmModel& next : changed) {
    std::vector<double> shafts = kOnePose;
    shafts.resize(next.muscles.size());
    BulletArm arm(model, {});
    replayPose(arm, kOtherPose, {});
    arm.setModel(next);
    const PoseOutcome found = replayPose(arm, shafts, {});
    ASSERT_EQ(found.status, PoseStatus::kSteady);
    expectSameBits(found, fresh(next, shafts));
    EXPECT_NE(found.joints[1].angle, before.joints[1].angle) << "the change matters";
  }
}

TEST(BulletArm, MovesToAnotherOwnerWithItsState) {
  BulletArm arm(test::exampleArm(), {});
  BulletArm same(test::exampleArm(), {});
  for (BulletArm* a : {&arm, &same}) a->setShaftReferences(kOnePose);
  run(arm, 0.5);
  run(same, 0.5);
  BulletArm moved = std::move(arm);
  run(moved, 0.5);
  run(same, 0.5);
  EXPECT_EQ(moved.jointPosition(1).angle, same.jointPosition(1).angle);
  EXPECT_EQ(moved.time(), same.time());
}

TEST(BulletArm, ReportsARunaway) {
  ArmModel model = test::torso();
  test::addLink(model, 0, JointType::kSpherical, {0, 0, 0}, {test::sphere(1e-6, {0, 0, -0.1}, 1e-3)});
  test::addMuscle(model, {0, {0, 0.05, 0}}, {1, {0, 0, -0.1}}, 0.05).shock_cord.stiffness = 1e12;
  BulletArm arm(model, {});
  EXPECT_TRUE(arm.isFinite());
  run(arm, 0.1);
  EXPECT_FALSE(arm.isFinite());
  run(arm, 1.0);
  EXPECT_FALSE(arm.isFinite()) << "and stays so";
  EXPECT_EQ(replayPose(arm, std::vector<double>{1.0}, {}).status, PoseStatus::kNotFinite);
  arm.reset();
  EXPECT_TRUE(arm.isFinite());
}

}  // namespace
}  // namespace simgap
