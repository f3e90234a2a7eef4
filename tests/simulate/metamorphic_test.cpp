// Changes of a model whose effect on the pose is known without knowing the pose.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/arms.h"
#include "support/statics.h"

namespace simgap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The example arm and three random ones (chains and trees), each with shaft angles that lead to a stable pose.
struct Alike {
  std::string name;
  ArmModel model;
  std::vector<double> shafts;
};

std::vector<Alike> alikes() {
  std::vector<Alike> result;
  result.push_back({"example", test::exampleArm(), {0.5, 2.0, 0.5, -1.0, 1.0, 2.0, 1.5, -1.0, 1.0, 2.5, 0.5}});
  for (const std::uint64_t seed : {3, 8, 15}) {
    const reality::Arm arm = reality::randomArm(seed);
    result.push_back({"random " + std::to_string(seed), test::modelOf(arm, true), reality::randomShafts(arm, seed)});
  }
  return result;
}

PoseOutcome replay(const ArmModel& model, const std::vector<double>& shafts) {
  BulletArm arm(model, {});
  PoseOutcome outcome = replayPose(arm, shafts, test::patientProtocol(0.02));
  EXPECT_EQ(outcome.status, PoseStatus::kSteady);
  outcome.joints.resize(model.joints.size());  // so that a pose that is not steady fails and does no more
  outcome.shafts.resize(model.muscles.size());
  return outcome;
}

// Changes every vector of a model: `polar` for places and directions, `axial` for the axes of hinges. Cylinders and
// spheres only: a box lies along its body's axes.
ArmModel transformed(ArmModel model, const Matrix3d& polar, const Matrix3d& axial) {
  model.gravity = polar * model.gravity;
  for (Body& body : model.bodies) {
    for (Part& part : body.parts) {
      part.position = polar * part.position;
      part.axis = (polar * part.axis).normalized();
    }
  }
  for (Joint& joint : model.joints) {
    joint.parent_position = polar * joint.parent_position;
    joint.child_position = polar * joint.child_position;
    joint.axis = (axial * joint.axis).normalized();
  }
  for (Muscle& muscle : model.muscles) {
    for (Attachment& attachment : muscle.attachments) attachment.point = polar * attachment.point;
  }
  return model;
}

// Expects the transformed arm at q' = polar q polar^T, hinges at the same angle.
void expectTransformed(const Alike& c, const Matrix3d& polar, const Matrix3d& axial) {
  const PoseOutcome expected = replay(c.model, c.shafts);
  const PoseOutcome found = replay(transformed(c.model, polar, axial), c.shafts);
  std::vector<JointPosition> moved = expected.joints;
  for (JointPosition& position : moved) {
    position.rotation = Eigen::Quaterniond(Matrix3d(polar * position.rotation.toRotationMatrix() * polar.transpose()));
  }
  // Rounding, carried through a motion that friction makes forget it: far below 1e-6 rad.
  EXPECT_LT(test::largestError(c.model, moved, found.joints), 1e-6) << c.name;
  EXPECT_GT(test::largestError(c.model, startPosition(c.model), expected.joints), 0.05) << c.name << " did not move";
}

TEST(Metamorphic, TheWholeWorldTurned) {
  std::mt19937 random(4);
  for (const Alike& c : alikes()) {
    const Matrix3d turn = test::randomRotation(random).toRotationMatrix();
    expectTransformed(c, turn, turn);
  }
}

TEST(Metamorphic, TheArmInAMirror) {
  // A mirrored turn by an angle about a is a turn by the same angle about minus the mirrored a.
  for (const Vector3d& normal : {Vector3d(1.0, 0.0, 0.0), Vector3d(0.6, 0.0, 0.8)}) {
    const Matrix3d mirror = Matrix3d::Identity() - 2.0 * normal * normal.transpose();
    for (const Alike& c : alikes()) expectTransformed(c, mirror, -mirror);
  }
}

TEST(Metamorphic, MusclesInAnotherOrder) {
  for (const Alike& c : alikes()) {
    std::vector<std::size_t> order(c.shafts.size());
    std::iota(order.begin(), order.end(), 0u);
    std::rotate(order.begin(), order.begin() + 3, order.end());
    std::swap(order[0], order[1]);
    ArmModel shuffled = c.model;
    std::vector<double> shafts = c.shafts;
    for (std::size_t m = 0; m < order.size(); ++m) {
      shuffled.muscles[m] = c.model.muscles[order[m]];
      shafts[m] = c.shafts[order[m]];
    }
    const PoseOutcome expected = replay(c.model, c.shafts);
    const PoseOutcome found = replay(shuffled, shafts);
    EXPECT_LT(test::largestError(c.model, expected.joints, found.joints), 1e-9) << c.name << ": the sum's rounding";
    for (std::size_t m = 0; m < order.size(); ++m) EXPECT_NEAR(found.shafts[m], expected.shafts[order[m]], 1e-9);
  }
}

// Every torque of a drive times `factor`, at the same voltage, current and speed. The back-EMF constant and the
// circuit stay: K_T and K_E are separate parameters (eq. 8, 9).
void scaleDrive(Muscle& muscle, double factor) {
  for (double* value : {&muscle.motor.torque_constant, &muscle.motor.inertia, &muscle.motor.viscous_friction,
                        &muscle.motor.coulomb_friction, &muscle.gearbox.inertia, &muscle.gearbox.viscous_friction,
                        &muscle.gearbox.coulomb_friction}) {
    *value *= factor;
  }
}

TEST(Metamorphic, MassesAndForcesScaledTogether) {
  // Masses, cords, frictions and drive torques times s: every equation of motion is multiplied by s.
  for (const double factor : {4.0, 0.3}) {
    for (const Alike& c : alikes()) {
      ArmModel scaled = c.model;
      for (Body& body : scaled.bodies) {
        for (Part& part : body.parts) part.mass *= factor;
      }
      for (Joint& joint : scaled.joints) {
        joint.coulomb_friction *= factor;
        joint.viscous_friction *= factor;
      }
      for (Muscle& muscle : scaled.muscles) {
        muscle.shock_cord.stiffness *= factor;
        muscle.shock_cord.damping *= factor;
        scaleDrive(muscle, factor);
      }
      const PoseOutcome expected = replay(c.model, c.shafts);
      const PoseOutcome found = replay(scaled, c.shafts);
      EXPECT_LT(test::largestError(c.model, expected.joints, found.joints), 1e-6) << c.name << " times " << factor;
      EXPECT_EQ(found.duration, expected.duration);
    }
  }
}

TEST(Metamorphic, OneMuscleAsTwoOfHalfTheStrength) {
  // Two cords of k/2 and D/2 side by side, each with a drive of half the torque that so reaches the same angle.
  for (const Alike& c : alikes()) {
    ArmModel split = c.model;
    std::vector<double> shafts = c.shafts;
    Muscle& half = split.muscles[1];
    half.shock_cord.stiffness *= 0.5;
    half.shock_cord.damping *= 0.5;
    scaleDrive(half, 0.5);
    const Muscle twin = half;
    split.muscles.push_back(twin);
    shafts.push_back(c.shafts[1]);
    const PoseOutcome expected = replay(c.model, c.shafts);
    const PoseOutcome found = replay(split, shafts);
    EXPECT_LT(test::largestError(c.model, expected.joints, found.joints), 1e-6) << c.name;
    EXPECT_NEAR(found.shafts[1], expected.shafts[1], 1e-6);
    EXPECT_EQ(found.shafts.back(), found.shafts[1]) << "twins do the same";
  }
}

TEST(Metamorphic, LineAndRestLengthMatterOnlyAsASum) {
  for (const Alike& c : alikes()) {
    ArmModel shifted = c.model;
    for (Muscle& muscle : shifted.muscles) {
      muscle.kite_line_length -= 0.01;
      muscle.shock_cord.rest_length += 0.01;
    }
    const PoseOutcome expected = replay(c.model, c.shafts);
    const PoseOutcome found = replay(shifted, c.shafts);
    EXPECT_LT(test::largestError(c.model, expected.joints, found.joints), 1e-9) << c.name;
  }
}

TEST(Metamorphic, AMuscleKnowsNoBeginningAndNoEnd) {
  for (const Alike& c : alikes()) {
    ArmModel swapped = c.model;
    for (Muscle& muscle : swapped.muscles) std::swap(muscle.attachments[0], muscle.attachments[1]);
    const PoseOutcome expected = replay(c.model, c.shafts);
    EXPECT_LT(test::largestError(c.model, expected.joints, replay(swapped, c.shafts).joints), 1e-9) << c.name;
  }
}

}  // namespace
}  // namespace simgap
