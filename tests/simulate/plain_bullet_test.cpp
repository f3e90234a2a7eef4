// The same arm in a plain multibody world of Bullet, with Bullet's own joint motors and limits as friction and stops.
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "simgap/simulate/bullet.h"
#include "simgap/simulate/bullet_arm.h"
#include "support/arms.h"

namespace simgap {
namespace {

using Eigen::Vector3d;

// A chain of hinges, each link one box whose axes are the body's: written with Bullet alone.
struct Segment {
  double mass;
  Vector3d size;
  Vector3d axis;
  Vector3d pivot_in_parent;  // from the parent's pivot
  Vector3d centre;           // from the link's pivot
  double start, speed;
  double coulomb = 0.0;
  double lower = -1e9, upper = 1e9;
};

class PlainBullet {
 public:
  PlainBullet(const std::vector<Segment>& segments, double step)
      : step_(step), body_(static_cast<int>(segments.size()), 0.0, btVector3(0, 0, 0), true, false) {
    world_.setGravity({0.0, 0.0, -test::kGravity});
    body_.setLinearDamping(0.0);
    body_.setAngularDamping(0.0);
    Vector3d parent_centre = Vector3d::Zero();
    for (int i = 0; i < body_.getNumLinks(); ++i) {
      const Segment& s = segments[i];
      const Vector3d square = s.size.cwiseAbs2();
      const Vector3d inertia = s.mass / 12.0 * (Vector3d::Constant(square.sum()) - square);
      body_.setupRevolute(i, s.mass, toBullet(inertia), i - 1, btQuaternion::getIdentity(), toBullet(s.axis),
                          toBullet(Vector3d(s.pivot_in_parent - parent_centre)), toBullet(s.centre), true);
      parent_centre = s.centre;
    }
    body_.finalizeMultiDof();
    world_.addMultiBody(&body_);
    for (int i = 0; i < body_.getNumLinks(); ++i) addLink(i, segments[i]);
    // Enough sweeps for friction and limits to settle; Bullet's default is 10.
    world_.getSolverInfo().m_numIterations = 300;
    world_.getSolverInfo().m_leastSquaresResidualThreshold = 1e-30;
    // Bullet lets a joint pass its stop by up to a step's way; pushing it back in the next step (a fifth of the way)
    // would throw it off with up to a fifth of its speed, however short the step.
    world_.getSolverInfo().m_erp = world_.getSolverInfo().m_erp2 = 0.0;
  }
  ~PlainBullet() {
    for (const auto& constraint : constraints_) world_.removeMultiBodyConstraint(constraint.get());
    for (const auto& collider : colliders_) world_.removeCollisionObject(collider.get());
    world_.removeMultiBody(&body_);
  }
  PlainBullet(const PlainBullet&) = delete;
  PlainBullet& operator=(const PlainBullet&) = delete;

  void step() { world_.stepSimulation(step_, 0); }
  double angle(int link) const { return body_.getJointPos(link); }
  double speed(int link) const { return std::abs(body_.getJointVel(link)); }

 private:
  // Without a collider Bullet ignores the constraints of a link; mask 0: it collides with nothing.
  void addLink(int i, const Segment& s) {
    auto collider = std::make_unique<btMultiBodyLinkCollider>(&body_, i);
    collider->setCollisionShape(&shape_);
    body_.getLink(i).m_collider = collider.get();
    world_.addCollisionObject(collider.get(), btBroadphaseProxy::DefaultFilter, 0);
    colliders_.push_back(std::move(collider));
    if (s.coulomb > 0.0) {
      constraints_.push_back(std::make_unique<btMultiBodyJointMotor>(&body_, i, 0.0, s.coulomb * step_));
    }
    if (s.lower > -1e8) {
      constraints_.push_back(std::make_unique<btMultiBodyJointLimitConstraint>(&body_, i, s.lower, s.upper));
    }
    while (world_.getNumMultiBodyConstraints() < static_cast<int>(constraints_.size())) {
      btMultiBodyConstraint* added = constraints_[world_.getNumMultiBodyConstraints()].get();
      world_.addMultiBodyConstraint(added);
      added->finalizeMultiDof();
    }
    body_.setJointPos(i, s.start);
    body_.setJointVel(i, s.speed);
  }

  double step_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btSimpleBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btMultiBody body_;
  btSphereShape shape_{0.001};
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints_;
};

BulletArm ours(const std::vector<Segment>& segments, double step) {
  ArmModel model = test::torso();
  std::vector<JointPosition> start;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& s = segments[i];
    Joint& joint = test::addLink(model, static_cast<int>(i), JointType::kRevolute, s.pivot_in_parent,
                                 {test::box(s.mass, s.centre, s.size)});
    joint.axis = s.axis;
    joint.coulomb_friction = s.coulomb;
    joint.lower_limit = s.lower;
    joint.upper_limit = s.upper;
    start.push_back(test::hingeAt(s.start));
  }
  BulletArmOptions options;
  options.step = step;
  BulletArm arm(model, options);
  arm.setJointPositions(start);
  for (std::size_t i = 0; i < segments.size(); ++i) arm.setJointVelocity(i, {segments[i].speed, 0.0, 0.0});
  return arm;
}

std::vector<Segment> plainChain() {
  return {{1.2, {0.05, 0.08, 0.3}, Vector3d::UnitX(), {0.1, 0.0, 0.2}, {0.02, 0.01, -0.15}, 0.4, 1.0},
          {0.8, {0.04, 0.06, 0.25}, Vector3d(0.6, 0.8, 0.0), {0.02, 0.0, -0.3}, {0.0, 0.03, -0.12}, -0.5, 2.0},
          {0.5, {0.05, 0.03, 0.2}, Vector3d(0.0, 0.6, 0.8), {0.0, 0.01, -0.25}, {0.03, 0.0, -0.1}, 0.9, -1.5}};
}

// Largest difference of an angle over `duration` seconds. [rad]
double largestDifference(const std::vector<Segment>& segments, double duration, double step = 0.002) {
  PlainBullet plain(segments, step);
  BulletArm arm = ours(segments, step);
  double largest = 0.0;
  for (long i = std::lround(duration / step); i > 0; --i) {
    plain.step();
    arm.step();
    for (int j = 0; j < static_cast<int>(segments.size()); ++j) {
      largest = std::max(largest, std::abs(plain.angle(j) - arm.jointPosition(j).angle));
    }
  }
  return largest;
}

TEST(PlainBullet, FreeMotionIsTheSame) {
  // Rounding of other link axes, amplified by a chain that is nearly chaotic: 1e-16 becomes 1e-12 within 2 s.
  EXPECT_LT(largestDifference(plainChain(), 2.0), 1e-10);
}

TEST(PlainBullet, CoulombFrictionIsTheSame) {
  std::vector<Segment> segments = plainChain();
  segments[0].coulomb = 0.3;
  segments[1].coulomb = 0.1;
  segments[2].coulomb = 0.05;
  EXPECT_LT(largestDifference(segments, 2.0), 1e-8) << "sweeps of the two solvers end at 1e-11 rad/s";
}

// The second hinge falls on its stop.
std::vector<Segment> stoppedChain(double coulomb) {
  std::vector<Segment> segments = plainChain();
  for (Segment& s : segments) s.coulomb = coulomb;
  segments[1].lower = 0.2;
  segments[1].upper = 2.0;
  segments[1].start = 0.3;
  return segments;
}

TEST(PlainBullet, LimitsAgreeMoreAndMoreAsTheStepShrinks) {
  // Bullet's joint stops up to a step beyond its stop, ours on it: speed times step, in proportion to the step.
  const double coarse = largestDifference(stoppedChain(0.1), 0.6, 0.002);
  const double fine = largestDifference(stoppedChain(0.1), 0.6, 0.0001);
  EXPECT_LT(coarse, 0.03);
  EXPECT_LT(fine, coarse / 5.0) << coarse << " with 2 ms";
}

TEST(PlainBullet, LimitsAndFrictionComeToRestAtTheSamePlace) {
  constexpr double kFineStep = 0.0005;
  const std::vector<Segment> segments = stoppedChain(0.8);
  PlainBullet plain(segments, kFineStep);
  BulletArm arm = ours(segments, kFineStep);
  for (int i = 0; i < 6000; ++i) {
    plain.step();
    arm.step();
  }
  for (int j = 0; j < 3; ++j) {
    // Friction keeps what the impact made different: a few rad/s times the step.
    EXPECT_NEAR(plain.angle(j), arm.jointPosition(j).angle, 0.003) << "joint " << j;
    EXPECT_LT(arm.jointSpeed(j), 1e-9);
  }
  EXPECT_NEAR(arm.jointPosition(1).angle, 0.2, 1e-12);
}

}  // namespace
}  // namespace simgap
