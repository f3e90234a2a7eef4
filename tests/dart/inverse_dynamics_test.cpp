// Torques of random trees against DART's inverse dynamics: hinges and slides between turned frames, one to three to a
// body, and joints that follow others.
#include <gtest/gtest.h>

#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>

#include "simgap/model/arm/inverse_dynamics.h"
#include "support/arms.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kFollower = 5;  // a joint of every longer tree moves with joint 2
constexpr double kRatio = -0.7;

Vector3d randomPoint(std::mt19937& random, double size) {
  const Vector3d direction = test::randomDirection(random);
  return size * test::uniform(random, 0.2, 1.0) * direction;
}

ArmModel randomTree(std::mt19937& random, int joints, bool chain) {
  ArmModel model = test::torso();
  model.gravity = Vector3d(1.5, -3.0, -8.0);
  for (int j = 0; j < joints; ++j) {
    const int parent = chain ? j : static_cast<int>(test::uniform(random, 0.0, j + 0.999));
    const Vector3d centre = randomPoint(random, 0.2);
    const Part mass = test::box(test::uniform(random, 0.5, 5.0), centre, {0.1, 0.2, 0.15});
    const JointType type = test::uniform(random, 0.0, 1.0) < 0.25 ? JointType::kPrismatic : JointType::kRevolute;
    Joint& joint = test::addLink(model, parent, type, randomPoint(random, 0.4), {mass});
    joint.axis = test::randomDirection(random);
    joint.parent_orientation = test::randomRotation(random);
    joint.child_orientation = test::randomRotation(random);
    joint.child_position = randomPoint(random, 0.2);
    if (j == kFollower) {
      joint.leader = 2;
      joint.coupling_ratio = kRatio;
      joint.coupling_offset = 0.3;
    }
  }
  return model;
}

template <typename DartJoint>
dart::dynamics::BodyNode* hang(const dart::dynamics::SkeletonPtr& skeleton, dart::dynamics::BodyNode* parent,
                               const Joint& joint) {
  const auto [made, body] = skeleton->createJointAndBodyNodePair<DartJoint>(parent);
  made->setAxis(joint.axis);
  made->setTransformFromParentBodyNode(Eigen::Translation3d(joint.parent_position) * joint.parent_orientation);
  made->setTransformFromChildBodyNode(Eigen::Translation3d(joint.child_position) * joint.child_orientation);
  return body;
}

VectorXd dartTorques(const ArmModel& model, const VectorXd& q, const VectorXd& v, const VectorXd& a) {
  const auto skeleton = dart::dynamics::Skeleton::create("tree");
  skeleton->setGravity(model.gravity);
  std::vector<dart::dynamics::BodyNode*> bodies(model.bodies.size(), nullptr);
  for (const Joint& joint : model.joints) {
    dart::dynamics::BodyNode*& body = bodies[joint.child];
    body = joint.slides() ? hang<dart::dynamics::PrismaticJoint>(skeleton, bodies[joint.parent], joint)
                          : hang<dart::dynamics::RevoluteJoint>(skeleton, bodies[joint.parent], joint);
    const MassProperties mass = massProperties(model.bodies[joint.child]);
    body->setInertia(dart::dynamics::Inertia(mass.mass, mass.centre_of_mass, mass.inertia));
  }
  VectorXd torques(q.size());
  for (Index j = 0; j < q.size(); ++j) {
    dart::dynamics::Joint* joint = skeleton->getJoint(bodies[model.joints[j].child]->getParentJoint()->getName());
    joint->setPosition(0, q[j]);
    joint->setVelocity(0, v[j]);
    joint->setAcceleration(0, a[j]);
  }
  skeleton->computeInverseDynamics();
  for (Index j = 0; j < q.size(); ++j) torques[j] = bodies[model.joints[j].child]->getParentJoint()->getForce(0);
  return torques;
}

double worstDifference(int joints, bool chain, unsigned seed) {
  std::mt19937 random(seed);
  const ArmModel model = randomTree(random, joints, chain);
  const InverseDynamics dynamics(model);
  InverseDynamics::Workspace work = dynamics.workspace();
  const Index n = std::ssize(dynamics.joints());
  RegressorMatrix y(n, dynamics.parameters());
  double worst = 0.0;
  for (int repeat = 0; repeat < 5; ++repeat) {
    std::vector<double> q, v, a;
    for (Index c = 0; c < n; ++c) {
      q.push_back(test::uniform(random, -3.0, 3.0));
      v.push_back(test::uniform(random, -3.0, 3.0));
      a.push_back(test::uniform(random, -9.0, 9.0));
    }
    dynamics.regressor(q, v, a, model.gravity, work, y);
    const VectorXd ours = y * dynamics.parametersOf(model);
    VectorXd all_q(joints), all_v(joints), all_a(joints);
    Index c = 0;
    for (Index j = 0; j < joints; ++j) {
      const bool follows = model.joints[j].follows();
      all_q[j] = follows ? 0.3 + kRatio * all_q[2] : q[c];
      all_v[j] = follows ? kRatio * all_v[2] : v[c];
      all_a[j] = follows ? kRatio * all_a[2] : a[c];
      if (!follows) ++c;
    }
    VectorXd theirs = dartTorques(model, all_q, all_v, all_a);
    if (joints > kFollower) {
      theirs[2] += kRatio * theirs[kFollower];
      theirs.segment(kFollower, joints - kFollower - 1) = theirs.tail(joints - kFollower - 1).eval();
      theirs.conservativeResize(joints - 1);
    }
    worst = std::max(worst, (ours - theirs).norm() / theirs.norm());
  }
  return worst;
}

TEST(InverseDynamicsDart, TorquesOfTreesAndChains) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const int joints = 1 + static_cast<int>(seed % 8);
    EXPECT_LT(worstDifference(joints, false, seed), 1e-12) << "tree of " << joints << ", seed " << seed;
    EXPECT_LT(worstDifference(joints, true, 100 + seed), 1e-12) << "chain of " << joints << ", seed " << seed;
  }
}

}  // namespace
}  // namespace simgap
