// Motions of random arms against DART's equations of motion: DART says how the arm accelerates, Runge-Kutta of fourth
// order plays it here. Shafts stand still; joints begin turned away from rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>

#include "simgap/core/random.h"
#include "simgap/simulate/rollout.h"
#include "support/arms.h"
#include "support/statics.h"
#include "support/step_study.h"

namespace simgap {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Smooth, and with gears that no line turns back.
ArmModel heldArm(std::uint64_t seed) {
  reality::Arm arm = reality::randomArm(seed);
  for (reality::Link& link : arm.links) {
    link.coulomb = 0.0;
    link.lower = -INFINITY;
    link.upper = INFINITY;
  }
  ArmModel model = test::modelOf(arm, false);
  for (Muscle& muscle : model.muscles) muscle.gearbox.coulomb_friction = 1e3;
  return model;
}

class DartArm {
 public:
  DartArm(const ArmModel& model, std::vector<double> shafts) : model_(model), shafts_(std::move(shafts)) {
    namespace dyn = dart::dynamics;
    skeleton_ = dyn::Skeleton::create("arm");
    skeleton_->setGravity(model.gravity);
    bodies_.assign(model.bodies.size(), nullptr);
    for (const Joint& joint : model.joints) {
      dyn::BodyNode* parent = bodies_[joint.parent];
      dyn::Joint* made = nullptr;
      if (joint.type == JointType::kSpherical) {
        const auto pair = skeleton_->createJointAndBodyNodePair<dyn::BallJoint>(parent);
        made = pair.first;
        bodies_[joint.child] = pair.second;
      } else {
        const auto pair = skeleton_->createJointAndBodyNodePair<dyn::RevoluteJoint>(parent);
        pair.first->setAxis(joint.axis);
        made = pair.first;
        bodies_[joint.child] = pair.second;
      }
      made->setTransformFromParentBodyNode(Eigen::Isometry3d(Eigen::Translation3d(joint.parent_position)));
      made->setTransformFromChildBodyNode(Eigen::Isometry3d(Eigen::Translation3d(joint.child_position)));
      const MassProperties mass = massProperties(model.bodies[joint.child]);
      bodies_[joint.child]->setInertia(dyn::Inertia(mass.mass, mass.centre_of_mass, mass.inertia));
    }
  }

  /// State: per joint a quaternion (w first) or an angle, then the velocities.
  VectorXd stateAt(const std::vector<JointPosition>& joints) const {
    VectorXd state = VectorXd::Zero(positions() + static_cast<int>(skeleton_->getNumDofs()));
    int at = 0;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      if (model_.joints[j].type == JointType::kSpherical) {
        const Quaterniond& q = joints[j].rotation;
        state.segment<4>(at) << q.w(), q.x(), q.y(), q.z();
        at += 4;
      } else {
        state[at++] = joints[j].angle;
      }
    }
    return state;
  }

  std::vector<JointPosition> jointsAt(const VectorXd& state) const {
    std::vector<JointPosition> joints(model_.joints.size());
    int at = 0;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      if (model_.joints[j].type == JointType::kSpherical) {
        joints[j].rotation = Quaterniond(state[at], state[at + 1], state[at + 2], state[at + 3]).normalized();
        at += 4;
      } else {
        joints[j].angle = state[at++];
      }
    }
    return joints;
  }

  VectorXd derivative(const VectorXd& state) {
    const auto joints = jointsAt(state);
    const VectorXd v = state.tail(skeleton_->getNumDofs());
    VectorXd change = VectorXd::Zero(state.size()), torque = VectorXd::Zero(v.size());
    int at = 0;
    Eigen::Index dof = 0;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      dart::dynamics::Joint* joint = skeleton_->getJoint(j);
      if (model_.joints[j].type == JointType::kSpherical) {
        joint->setPositions(dart::dynamics::BallJoint::convertToPositions(joints[j].rotation.toRotationMatrix()));
        joint->setVelocities(v.segment<3>(dof));
        const Quaterniond rate = joints[j].rotation * Quaterniond(0.0, v[dof], v[dof + 1], v[dof + 2]);
        change.segment<4>(at) << 0.5 * rate.w(), 0.5 * rate.x(), 0.5 * rate.y(), 0.5 * rate.z();
        torque.segment<3>(dof) = -model_.joints[j].viscous_friction * v.segment<3>(dof);
        at += 4;
        dof += 3;
      } else {
        joint->setPosition(0, joints[j].angle);
        joint->setVelocity(0, v[dof]);
        change[at++] = v[dof];
        torque[dof] = -model_.joints[j].viscous_friction * v[dof];
        ++dof;
      }
    }
    skeleton_->setForces(torque);
    skeleton_->clearExternalForces();
    for (std::size_t m = 0; m < model_.muscles.size(); ++m) pull(m);
    skeleton_->computeForwardDynamics();
    change.tail(v.size()) = skeleton_->getAccelerations();
    return change;
  }

 private:
  int positions() const {
    int count = 0;
    for (const Joint& joint : model_.joints) count += joint.type == JointType::kSpherical ? 4 : 1;
    return count;
  }

  void pull(std::size_t m) {
    const Muscle& muscle = model_.muscles[m];
    std::array<Vector3d, 2> point, velocity;
    for (std::size_t end = 0; end < 2; ++end) {
      const dart::dynamics::BodyNode* body = bodies_[muscle.attachments[end].body];
      const Vector3d& at = muscle.attachments[end].point;
      point[end] = body != nullptr ? Vector3d(body->getWorldTransform() * at) : at;
      velocity[end] = body != nullptr ? body->getLinearVelocity(at) : Vector3d(Vector3d::Zero());
    }
    const double length = (point[1] - point[0]).norm();
    const Vector3d along = (point[1] - point[0]) / length;
    const double force =
        muscle.shock_cord.force(length - muscle.kiteLineLength(shafts_[m]), along.dot(velocity[1] - velocity[0]));
    for (std::size_t end = 0; end < 2; ++end) {
      dart::dynamics::BodyNode* body = bodies_[muscle.attachments[end].body];
      if (body == nullptr) continue;
      body->addExtForce(end == 0 ? Vector3d(force * along) : Vector3d(-force * along), muscle.attachments[end].point,
                        /*isForceLocal=*/false, /*isOffsetLocal=*/true);
    }
  }

  const ArmModel& model_;
  std::vector<double> shafts_;
  dart::dynamics::SkeletonPtr skeleton_;
  std::vector<dart::dynamics::BodyNode*> bodies_;
};

constexpr double kInterval = 0.1, kEnd = 2.0;  // [s]

/// Largest angle of a joint between the simulation and DART over two seconds, per step. [rad]
std::vector<double> largestDifferences(std::uint64_t seed, const std::vector<double>& steps) {
  const ArmModel model = heldArm(seed);
  const CounterRandom random(seed);
  MotionStart start;
  start.joints = startPosition(model);
  for (std::uint32_t j = 0; j < start.joints.size(); ++j) {
    const Vector3d axis(random.uniform({0, j, 0, 5}) - 0.5, random.uniform({0, j, 1, 5}) - 0.5, 0.3);
    start.joints[j].rotation = Quaterniond(Eigen::AngleAxisd(0.5, axis.normalized()));
    start.joints[j].angle += 0.4;
  }
  for (std::uint32_t m = 0; m < model.muscles.size(); ++m) start.shafts.push_back(3.0 * random.uniform({0, m, 0, 6}));

  MotionCommands commands;
  commands.kinds.assign(model.muscles.size(), CommandKind::kVoltage);
  commands.times = {0.0};
  commands.values = Eigen::MatrixXd::Zero(std::ssize(model.muscles), 1);
  std::vector<double> times;
  for (int i = 0; i * kInterval < kEnd + 1e-9; ++i) times.push_back(i * kInterval);
  DartArm dart(model, start.shafts);
  VectorXd y = dart.stateAt(start.joints);
  constexpr double kStep = 0.0005;
  std::vector<std::vector<JointPosition>> truth{start.joints};
  for (std::size_t row = 1; row < times.size(); ++row) {
    for (int i = 0; i < std::lround(kInterval / kStep); ++i) {
      const VectorXd k1 = dart.derivative(y);
      const VectorXd k2 = dart.derivative(y + 0.5 * kStep * k1);
      const VectorXd k3 = dart.derivative(y + 0.5 * kStep * k2);
      const VectorXd k4 = dart.derivative(y + kStep * k3);
      y += kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    truth.push_back(dart.jointsAt(y));
  }

  return test::largestPerStep(model, commands, start, times, steps, [&](const MotionTrack& track, std::size_t row) {
    return test::largestError(model, track.jointsAt(row), truth[row]);
  });
}

TEST(DartAgreement, RandomArmsMoveAlike) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    EXPECT_LT(toDegrees(largestDifferences(seed, {0.0005})[0]), 0.05) << "arm " << seed;
  }
}

// The study behind docs/studies/simulation.md.
TEST(SlowDartAgreement, FiftyRandomArms) {
  const std::vector<double> largest = test::studySteps({0.001, 0.0005, 0.00025, 0.000125}, largestDifferences);
  EXPECT_LE(largest[1], 0.05);
}

}  // namespace
}  // namespace simgap
