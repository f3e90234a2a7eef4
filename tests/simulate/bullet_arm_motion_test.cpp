// Free motion: period, energy and momentum. Nothing here uses a mass matrix; the judge sums over the parts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "simgap/simulate/bullet_arm.h"
#include "support/arms.h"

namespace simgap {
namespace {

using Eigen::Vector3d;
using test::addLink;
using test::box;
using test::cylinder;
using test::sphere;

BulletArmOptions stepOf(double step) {
  BulletArmOptions options;
  options.step = step;
  return options;
}

std::vector<JointPosition> positionsOf(const BulletArm& arm) {
  std::vector<JointPosition> positions;
  for (std::size_t j = 0; j < arm.joints(); ++j) positions.push_back(arm.jointPosition(j));
  return positions;
}

JointPosition turned(double angle, const Vector3d& axis) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())), angle};
}

// Arithmetic-geometric mean, by which Gauss gave the complete elliptic integral.
double mean(double a, double b) {
  while (std::abs(a - b) > 1e-15 * a) {
    const double arithmetic = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = arithmetic;
  }
  return a;
}

// Time between crossings of the straight position in the same direction, averaged over 3 swings.
double periodOf(const ArmModel& model, double amplitude, double step, const std::function<double(BulletArm&)>& angle) {
  BulletArm arm(model, stepOf(step));
  arm.setJointPositions(std::vector<JointPosition>{turned(amplitude, Vector3d::UnitX())});
  std::vector<double> crossings;
  double before = angle(arm);
  while (crossings.size() < 4 && arm.time() < 20.0) {
    arm.step();
    const double now = angle(arm);
    if (before < 0.0 && now >= 0.0) crossings.push_back(arm.time() - step * now / (now - before));
    before = now;
  }
  return crossings.size() == 4 ? (crossings[3] - crossings[0]) / 3.0 : 0.0;
}

double hingeAngle(BulletArm& arm) { return arm.jointPosition(0).angle; }
double ballAngle(BulletArm& arm) {
  const Eigen::Quaterniond q = arm.jointPosition(0).rotation;
  return 2.0 * std::atan2(q.x(), q.w());
}

TEST(BulletArmMotion, PendulumSwingsWithThePeriodOfTheEllipticIntegral) {
  const double slow = std::sqrt(test::kPendulumMass * test::kGravity * test::kPendulumLength / test::kPendulumInertia);
  for (const double amplitude : {0.05, 0.8, 2.0, 3.0}) {
    const double period = 2.0 * M_PI / (slow * mean(1.0, std::cos(0.5 * amplitude)));
    for (const JointType type : {JointType::kRevolute, JointType::kSpherical}) {
      const auto angle = type == JointType::kRevolute ? hingeAngle : ballAngle;
      const double coarse = periodOf(test::pendulum(type), amplitude, 0.002, angle) / period - 1.0;
      const double fine = periodOf(test::pendulum(type), amplitude, 0.001, angle) / period - 1.0;
      // Semi-implicit Euler has the period right to second order: (w dt)^2 / 24 = 1e-5 for small swings.
      EXPECT_LT(std::abs(coarse), 1e-4) << "amplitude " << amplitude;
      EXPECT_NEAR(coarse / fine, 4.0, 0.5) << "amplitude " << amplitude << ": " << coarse << ", " << fine;
    }
  }
}

TEST(BulletArmMotion, PivotInTheChildGivesTheSamePendulum) {
  // The same body, its frame moved to the mass: only parent_position and child_position differ.
  ArmModel moved = test::torso();
  addLink(moved, 0, JointType::kRevolute, {0.3, -0.1, 0.2}, {sphere(test::kPendulumMass, Vector3d::Zero())})
      .child_position = {0.0, 0.0, test::kPendulumLength};
  EXPECT_NEAR(periodOf(moved, 0.8, 0.002, hingeAngle), periodOf(test::pendulum(), 0.8, 0.002, hingeAngle), 1e-12);
}

// What moves, and how it is thrown.
struct Throw {
  std::string name;
  ArmModel model;
  std::vector<JointPosition> positions;
  std::vector<Vector3d> velocities;
};

const std::vector<Part> kLopsided = {cylinder(0.6, {0.01, 0.02, -0.1}, {0.3, -0.2, 1.0}),
                                     box(0.4, {-0.03, 0.01, -0.16}, {0.05, 0.09, 0.03}),
                                     sphere(0.2, {0.02, -0.04, -0.05}, 0.03)};

Throw hinge() {
  Throw t{"revolute", test::torso(), {turned(1.0, Vector3d::UnitX())}, {{4.0, 0.0, 0.0}}};
  Joint& joint = addLink(t.model, 0, JointType::kRevolute, {0.1, 0.0, 0.2}, kLopsided);
  joint.axis = Vector3d(1.0, -2.0, 0.5).normalized();
  joint.child_position = {0.02, -0.01, 0.03};
  return t;
}

Throw tumblingBall() {
  Throw t{"spherical", test::torso(), {turned(0.9, {1.0, 2.0, -1.0})}, {{3.0, -2.0, 4.0}}};
  addLink(t.model, 0, JointType::kSpherical, {0.1, 0.0, 0.2}, kLopsided).child_position = {0.02, -0.01, 0.03};
  return t;
}

Throw chain() {
  Throw t{"chain",
          test::torso(),
          {turned(0.4, {1.0, 1.0, 0.0}), turned(0.8, Vector3d::UnitX()), turned(0.5, {0.0, 1.0, 2.0})},
          {{1.0, -2.0, 1.5}, {2.0, 0.0, 0.0}, {-1.0, 1.0, 2.0}}};
  addLink(t.model, 0, JointType::kSpherical, {0.0, 0.0, 0.0}, kLopsided);
  addLink(t.model, 1, JointType::kRevolute, {0.01, 0.02, -0.25}, kLopsided).axis = Vector3d(0.8, 0.6, 0.0);
  addLink(t.model, 2, JointType::kSpherical, {0.0, 0.01, -0.22}, kLopsided).child_position = {0.01, 0.0, 0.02};
  return t;
}

Throw tree() {
  Throw t = chain();
  t.name = "tree";
  addLink(t.model, 1, JointType::kRevolute, {0.05, 0.0, -0.1}, kLopsided).axis = Vector3d(0.0, 0.6, 0.8);
  addLink(t.model, 0, JointType::kRevolute, {0.4, 0.0, 0.0}, kLopsided);
  addLink(t.model, 2, JointType::kSpherical, {0.0, 0.06, -0.1}, kLopsided);
  t.positions.insert(t.positions.end(),
                     {turned(-0.6, Vector3d::UnitX()), turned(1.2, Vector3d::UnitX()), turned(0.7, {1.0, 0.0, 1.0})});
  t.velocities.insert(t.velocities.end(), {Vector3d(1.5, 0, 0), Vector3d(-2, 0, 0), Vector3d(1.0, 0.5, -1.0)});
  return t;
}

// Largest deviation of energy and of angular momentum along `kept`, over one second.
struct Drift {
  double energy = 0.0;    // of the largest kinetic energy
  double momentum = 0.0;  // of its largest norm
};

Drift driftOf(const Throw& t, double step, const Vector3d& kept = Vector3d::Zero()) {
  BulletArm arm(t.model, stepOf(step));
  arm.setJointPositions(t.positions);
  for (std::size_t j = 0; j < t.velocities.size(); ++j) arm.setJointVelocity(j, t.velocities[j]);
  const test::Mechanics start = test::mechanics(t.model, t.positions, t.velocities);
  Drift drift;
  double largest = start.kinetic;
  double longest = 1e-9;
  std::vector<JointPosition> before = positionsOf(arm);
  for (long i = std::lround(1.0 / step); i > 0; --i) {
    arm.step();
    const std::vector<JointPosition> now = positionsOf(arm);
    const test::Mechanics m = test::mechanics(t.model, now, test::velocitiesBetween(t.model, before, now, step));
    drift.energy = std::max(drift.energy, std::abs(m.energy() - start.energy()));
    drift.momentum = std::max(drift.momentum, std::abs(kept.dot(m.angular_momentum - start.angular_momentum)));
    largest = std::max(largest, m.kinetic);
    longest = std::max(longest, m.angular_momentum.norm());
    before = now;
  }
  drift.energy /= largest;
  drift.momentum /= longest;
  return drift;
}

class Thrown : public testing::TestWithParam<Throw (*)()> {};

TEST_P(Thrown, EnergyErrorShrinksInProportionToTheStep) {
  const Throw t = GetParam()();
  const double coarse = driftOf(t, 0.002).energy;
  const double fine = driftOf(t, 0.0002).energy;
  const double finest = driftOf(t, 0.0001).energy;
  // Explicit Coriolis terms: 1 to 10 % of the largest kinetic energy in a second of fast tumbling.
  EXPECT_LT(coarse, 0.15) << t.name;
  EXPECT_NEAR(fine / finest, 2.0, 0.1) << t.name << ": first order, " << fine << " then " << finest;
}

INSTANTIATE_TEST_SUITE_P(BulletArmMotion, Thrown, testing::Values(hinge, tumblingBall, chain, tree),
                         [](const auto& about) { return about.param().name; });

TEST(BulletArmMotion, MomentumAboutTheVerticalThroughABallJointIsKept) {
  // Gravity has no torque about it, whatever hangs on the ball.
  for (Throw t : {tumblingBall(), chain()}) {
    t.model.joints[0].parent_position.setZero();
    const double fine = driftOf(t, 0.0002, Vector3d::UnitZ()).momentum;
    const double finest = driftOf(t, 0.0001, Vector3d::UnitZ()).momentum;
    EXPECT_LT(fine, 0.02) << t.name;
    EXPECT_NEAR(fine / finest, 2.0, 0.2) << t.name;
  }
}

TEST(BulletArmMotion, FreeBodySpinsAboutItsPrincipalAxisForever) {
  ArmModel model = test::torso();
  model.gravity.setZero();
  addLink(model, 0, JointType::kSpherical, Vector3d::Zero(), {box(1.0, Vector3d::Zero(), {0.1, 0.2, 0.3})});
  BulletArm arm(model, {});
  arm.setJointPositions(std::vector<JointPosition>{turned(0.7, {1.0, 2.0, 3.0})});
  arm.setJointVelocity(0, {0.0, 0.0, 5.0});
  for (int i = 0; i < 1000; ++i) arm.step();
  EXPECT_NEAR(arm.jointSpeed(0), 5.0, 1e-12);
  const Eigen::Quaterniond expected = turned(0.7, {1.0, 2.0, 3.0}).rotation * turned(10.0, Vector3d::UnitZ()).rotation;
  EXPECT_LT(geodesicAngle(arm.jointPosition(0).rotation, expected), 1e-11) << "1000 products of rotations";
}

}  // namespace
}  // namespace simgap
