// Every rule of the pose protocol by itself, then the nominal poses of the example arms.
#include "simgap/simulate/pose_protocol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "support/arms.h"

namespace simgap {
namespace {

using Eigen::Vector3d;

// ------------------------------------------------------------------------------------------------ acquisition

// Two muscles that pull nothing on a pendulum that friction holds.
ArmModel twoSlackMuscles() {
  ArmModel model = test::pendulum();
  model.joints[0].coulomb_friction = 100.0;
  for (int i = 0; i < 2; ++i) test::addMuscle(model, {0, {0, 0.05, 0}}, {1, {0, 0, -0.12}}, 1.0);
  return model;
}

TEST(PoseProtocol, NamesTheMuscleThatDoesNotArrive) {
  ArmModel model = twoSlackMuscles();
  model.muscles[1].motor.supply_voltage = 0.1;  // 0.07 N m of 0.13 N m Coulomb torque: does not move at all
  BulletArm arm(model, {});
  const PoseOutcome outcome = replayPose(arm, std::vector<double>{1.0, 2.0}, {});
  EXPECT_EQ(outcome.status, PoseStatus::kAcquisitionError);
  EXPECT_EQ(outcome.worst, 1);
  EXPECT_EQ(outcome.worst_value, 2.0);
  EXPECT_NEAR(outcome.duration, 5.0, 1e-9) << "t_a";
  EXPECT_TRUE(outcome.joints.empty());
}

TEST(PoseProtocol, AcquisitionErrorIsTheLargestShaftErrorOfEitherSign) {
  ArmModel model = twoSlackMuscles();
  for (Muscle& muscle : model.muscles) muscle.motor.supply_voltage = 0.1;
  BulletArm arm(model, {});
  EXPECT_EQ(replayPose(arm, std::vector<double>{-3.0, 2.0}, {}).worst, 0);
  // Just within 5 deg is no error, just beyond it is one.
  EXPECT_EQ(replayPose(arm, std::vector<double>{0.0, -4.999 * kDegree}, {}).status, PoseStatus::kSteady);
  EXPECT_EQ(replayPose(arm, std::vector<double>{0.0, -5.001 * kDegree}, {}).status, PoseStatus::kAcquisitionError);
}

TEST(PoseProtocol, ShaftsHaveAcquisitionTimeToArrive) {
  // No-load 14.8 rad/s: 60 rad take a little over 4.06 s.
  BulletArm arm(twoSlackMuscles(), {});
  PoseProtocol protocol;
  EXPECT_EQ(replayPose(arm, std::vector<double>{60.0, 0.0}, protocol).status, PoseStatus::kSteady);
  protocol.acquisition = 4.0;
  EXPECT_EQ(replayPose(arm, std::vector<double>{60.0, 0.0}, protocol).status, PoseStatus::kAcquisitionError);
}

TEST(PoseProtocol, TakesAsLongAsItsRulesSay) {
  // Friction holds the joint from the start, the shafts begin where they should be.
  BulletArm arm(twoSlackMuscles(), {});
  const std::vector<double> shafts = {0.0, 0.0};
  PoseProtocol protocol;
  EXPECT_NEAR(replayPose(arm, shafts, protocol).duration, 0.1 + 0.5, 1e-9) << "early_hold and t_d";
  protocol.early_hold = 0.3;
  protocol.steady = 0.2;
  EXPECT_NEAR(replayPose(arm, shafts, protocol).duration, 0.3 + 0.2, 1e-9);
  protocol.early_acquisition = false;
  EXPECT_NEAR(replayPose(arm, shafts, protocol).duration, 5.0 + 0.2, 1e-9) << "t_a and t_d";
}

TEST(PoseProtocol, EarlyHoldCountsFromTheLastTimeAShaftWasOutside) {
  // A heavy rotor overshoots: its shaft is within 5 deg of the reference several times before it stays.
  ArmModel model = twoSlackMuscles();
  model.muscles[0].motor.inertia = 4e-5;
  const std::vector<double> shafts = {3.0, 1.0};
  BulletArm arm(model, {});
  arm.setShaftReferences(shafts);
  double first = 0.0;
  double last = 0.0;
  while (arm.time() < 4.0) {
    arm.step();
    const bool outside = std::max(std::abs(arm.shaftError(0)), std::abs(arm.shaftError(1))) > 5.0 * kDegree;
    if (outside) last = arm.time();
    if (!outside && first == 0.0) first = arm.time();
  }
  ASSERT_GT(last, first + 0.5);
  EXPECT_NEAR(replayPose(arm, shafts, {}).duration, last + 0.1 + 0.5, 1e-9) << "and early_hold, t_d";
}

TEST(PoseProtocol, EarlyAcquisitionReachesThePaperPose) {
  // The shafts end at the same angles but for the friction of drives that creep in; joints without Coulomb friction
  // then have one place to rest, and 1e-4 rad/s leaves them within 0.01 deg of it.
  ArmModel model = test::exampleArm();
  for (Joint& joint : model.joints) {
    joint.coulomb_friction = 0.0;
    joint.viscous_friction *= 5.0;
  }
  PoseProtocol early;
  early.max_velocity = 1e-4;
  early.settle = 30.0;
  PoseProtocol paper = early;
  paper.early_acquisition = false;
  BulletArm arm(model, {});
  const CsvTable table = CsvTable::load(test::dataFile("arm") / "poses_calibration.csv");
  for (const Pose& pose : readPoseSet(table, model.poseLayout()).poses) {
    const PoseOutcome a = replayPose(arm, pose.shafts, early);
    const PoseOutcome b = replayPose(arm, pose.shafts, paper);
    ASSERT_EQ(a.status, PoseStatus::kSteady) << pose.name;
    ASSERT_EQ(b.status, PoseStatus::kSteady) << pose.name;
    EXPECT_LT(toDegrees(test::largestError(model, a.joints, b.joints)), 0.02) << pose.name;
    for (std::size_t m = 0; m < a.shafts.size(); ++m) EXPECT_NEAR(a.shafts[m], b.shafts[m], 1e-9);
  }
}

// ------------------------------------------------------------------------------------------------ steadiness

TEST(PoseProtocol, NamesTheJointThatDoesNotRest) {
  ArmModel model = test::torso();
  for (int i = 0; i < 3; ++i) {
    test::addLink(model, 0, JointType::kRevolute, {0.5 * i, 0, 0}, {test::sphere(1.0, {0, 0, -0.2})}).viscous_friction =
        i == 1 ? 0.0 : 2.0;
  }
  BulletArm arm(model, {});
  const PoseOutcome outcome = replayPose(arm, {}, {});
  EXPECT_EQ(outcome.status, PoseStatus::kNotSteady);
  EXPECT_EQ(outcome.worst, 1);
  EXPECT_GT(outcome.worst_value, 0.02);
  EXPECT_NEAR(outcome.duration, 0.1 + 5.0, 1e-9) << "early_hold and t_s";
}

TEST(PoseProtocol, SteadyMeansSteadyWithoutABreak) {
  // A pendulum without friction that swings at up to 0.04 rad/s is below 0.02 rad/s around every turning point, for a
  // sixth of its period. Every pose starts at 0.3 rad: gravity is tilted until that is a small amplitude.
  ArmModel model = test::pendulum();
  const double natural =
      std::sqrt(test::kPendulumMass * test::kGravity * test::kPendulumLength / test::kPendulumInertia);
  const double amplitude = 0.04 / natural;
  model.gravity = Eigen::AngleAxisd(0.3 - amplitude, Vector3d::UnitX()) * model.gravity;
  const double quiet = 2.0 * M_PI / natural / 6.0;
  BulletArm arm(model, {});
  PoseProtocol protocol;
  protocol.steady = quiet - 0.01;
  EXPECT_EQ(replayPose(arm, {}, protocol).status, PoseStatus::kSteady);
  protocol.steady = quiet + 0.01;
  EXPECT_EQ(replayPose(arm, {}, protocol).status, PoseStatus::kNotSteady) << "0.13 s at a time, 13 times";
  protocol.max_velocity = 0.041;
  EXPECT_EQ(replayPose(arm, {}, protocol).status, PoseStatus::kSteady);
}

TEST(PoseProtocol, WhatCreepsIsNotSteadyAndSaysWhenItWillBe) {
  // A pendulum in honey: overdamped, it comes down at m g l / c q, at first 0.3 rad from where it will hang.
  ArmModel model = test::pendulum();
  model.joints[0].viscous_friction = 40.0;
  const double rate = test::kPendulumMass * test::kGravity * test::kPendulumLength / 40.0;
  ASSERT_LT(0.3 * rate, 1.2 * PoseProtocol{}.max_velocity) << "slow enough to count as resting from the second second";
  BulletArm arm(model, {});
  PoseProtocol protocol;
  const PoseOutcome creeping = replayPose(arm, {}, protocol);
  ASSERT_EQ(creeping.status, PoseStatus::kNotSteady);
  EXPECT_EQ(creeping.worst, 0);
  EXPECT_LT(creeping.worst_value, protocol.max_velocity);
  EXPECT_NEAR(creeping.settle_needed, std::log(0.3 / (0.5 * kDegree)) / rate, 2.0);

  protocol.settle = 1.1 * creeping.settle_needed;
  const PoseOutcome rested = replayPose(arm, {}, protocol);
  ASSERT_EQ(rested.status, PoseStatus::kSteady);
  EXPECT_NEAR(rested.duration, creeping.settle_needed, 2.0);
  EXPECT_LT(std::abs(rested.joints[0].angle), 0.55 * kDegree);
}

TEST(PoseProtocol, ReportsARunaway) {
  ArmModel model = test::exampleArm();
  model.muscles[3].shock_cord.stiffness = 1e12;
  BulletArm arm(model, {});
  const PoseOutcome outcome = replayPose(arm, std::vector<double>(11, 1.0), {});
  EXPECT_EQ(outcome.status, PoseStatus::kNotFinite);
  EXPECT_LT(outcome.duration, 1.0) << "at once, not after t_a";
}

TEST(PoseProtocol, RefusesWhatCanNeverBeSteady) {
  PoseProtocol protocol;
  protocol.steady = 6.0;
  EXPECT_THROW(protocol.validate(), ConfigError);
}

TEST(PoseProtocol, ReadsBackWhatItWrites) {
  PoseProtocol protocol;
  protocol.acquisition = 3.5;
  protocol.max_shaft_error = 0.07;
  protocol.early_acquisition = false;
  protocol.arm.step = 0.001;
  const PoseProtocol read = PoseProtocol::read(YamlNode::parse(protocol.toYaml(""), "protocol.yaml"));
  EXPECT_EQ(read.toYaml("  "), protocol.toYaml("  "));
  EXPECT_EQ(read.arm, protocol.arm);
  EXPECT_EQ(read.max_shaft_error, 0.07);
}

// ------------------------------------------------------------------------------------------------ example arms

struct Errors {
  double revolute = 0.0, spherical = 0.0;  // mean over the poses [deg]
};

// Replays all poses of a file on the arm's nominal model and expects every one to come to rest.
Errors replayFile(const std::string& arm_name, const std::string& file) {
  const ArmModel model = test::exampleArm(arm_name);
  const PoseSet set = readPoseSet(CsvTable::load(test::dataFile(arm_name) / file), model.poseLayout());
  BulletArm arm(model, {});
  Errors errors;
  for (const Pose& pose : set.poses) {
    const PoseOutcome outcome = replayPose(arm, pose.shafts, {});
    EXPECT_EQ(outcome.status, PoseStatus::kSteady) << arm_name << " " << pose.name << ": " << toString(outcome.status)
                                                   << ", worst " << outcome.worst << " with " << outcome.worst_value;
    for (std::size_t j = 0; j < outcome.joints.size(); ++j) {
      const JointType type = model.joints[j].type;
      (type == JointType::kRevolute ? errors.revolute : errors.spherical) +=
          toDegrees(jointError(type, outcome.joints[j], pose.joints[j])) / static_cast<double>(set.poses.size());
    }
  }
  return errors;
}

// 0.15 deg: what the order of the sweeps, the step and early acquisition can change within the friction of the joints.
constexpr double kSpread = 0.15;

TEST(NominalPoses, OfTheArm) {
  const Errors calibration = replayFile("arm", "poses_calibration.csv");
  EXPECT_NEAR(calibration.spherical, 23.1, kSpread);
  EXPECT_NEAR(calibration.revolute, 26.5, kSpread);
  const Errors validation = replayFile("arm", "poses_validation.csv");
  EXPECT_NEAR(validation.spherical, 18.1, kSpread);
  EXPECT_NEAR(validation.revolute, 26.5, kSpread);
}

TEST(NominalPoses, OfTheHardArm) {
  const Errors calibration = replayFile("arm-hard", "poses_calibration.csv");
  EXPECT_NEAR(calibration.spherical, 38.4, kSpread);
  EXPECT_NEAR(calibration.revolute, 32.2, kSpread);
  replayFile("arm-hard", "poses_validation.csv");
}

TEST(NominalPoses, OfTheOtherArmsComeToRest) {
  for (const char* arm : {"arm-elbow", "arm-dense"}) {
    for (const char* file : {"poses_calibration.csv", "poses_validation.csv"}) {
      const Errors errors = replayFile(arm, file);
      EXPECT_GT(errors.revolute + errors.spherical, 1.0) << "nothing to calibrate in " << arm;
    }
  }
}

}  // namespace
}  // namespace simgap
