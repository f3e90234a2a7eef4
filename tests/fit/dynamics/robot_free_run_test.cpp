// Robots of tests/reality, whose torques come from Lagrange's equations, played from these torques; and what a resting
// joint, a controller and a wrong mass do, by hand.
#include "simgap/fit/dynamics/robot_free_run.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reality/robot_rig.h"
#include "simgap/core/error.h"
#include "support/robot_logs.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A log without noise. \param at  fills the positions, velocities and efforts, shape (N), of a time
template <class At>
RobotLog logOf(const RobotModel& model, double duration, double rate, At at) {
  RobotLog log;
  const std::vector<LoggedJoint> joints = loggedJoints(model.arm);
  for (const LoggedJoint& joint : joints) log.joints.emplace_back().name = joint.name;
  VectorXd q(std::ssize(joints)), v(q.size()), effort(q.size());
  for (int i = 0; i <= duration * rate; ++i) {
    log.time.push_back(i / rate);
    log.session.push_back(0);
    at(log.time.back(), q, v, effort);
    for (std::size_t c = 0; c < joints.size(); ++c) {
      log.joints[c].position.push_back(q[c]);
      log.joints[c].velocity.push_back(v[c]);
      log.joints[c].effort.push_back(effort[c]);
    }
  }
  return log;
}

TEST(RobotFreeRun, FollowsTheTorquesOfLagrange) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const reality::Robot robot = reality::randomRobot(seed, 2 + static_cast<int>(seed), seed % 2 == 0, true);
    const ArmModel arm = test::drawnArm(robot, 0);
    const std::vector<std::size_t> links = test::linksOfJoints(arm);
    const Index n = std::ssize(links);
    const RobotLog log =
        logOf(robotModelOf(arm), 0.6, 500.0, [&](double t, VectorXd& q, VectorXd& v, VectorXd& effort) {
          VectorXd place(n), rate(n), acceleration(n);
          for (Index k = 0; k < n; ++k) {
            const Index link = links[k];
            const double w = 2.0 + static_cast<double>(k), phase = static_cast<double>(k + seed);
            q[k] = place[link] = 0.3 * std::sin(w * t + phase);
            v[k] = rate[link] = 0.3 * w * std::cos(w * t + phase);
            acceleration[link] = -0.3 * w * w * std::sin(w * t + phase);
          }
          const VectorXd torques = reality::rigidTorques(robot, place, rate, acceleration);
          for (Index k = 0; k < n; ++k) effort[k] = torques[links[k]];
        });
    const RobotFreeRun run = runFreely(robotModelOf(arm), log, {});
    for (Index c = 0; c < n; ++c) {
      // The step is of first order: what is left is as large as what half the step changes.
      EXPECT_LT(run.rms[c], 3.0 * run.half_step[c] + 1e-5) << "seed " << seed << ", joint " << c;
      EXPECT_LT(run.rms[c], 0.02 * run.range[c]) << "seed " << seed << ", joint " << c;
    }
  }
}

/// A point of 2 kg on a rod of half a metre about a horizontal axis, friction 1 N m; q = 0: it hangs.
RobotModel pendulum(double mass) {
  reality::Robot robot;
  reality::RobotLink link;
  link.axis = Eigen::Vector3d::UnitX();
  link.centre = {0.0, 0.0, -0.5};
  link.mass = mass;
  link.inertia = 1e-4 * Eigen::Matrix3d::Identity();
  robot.links = {link};
  ArmModel arm = test::drawnArm(robot, 0);
  for (Joint& joint : arm.joints) joint.coulomb_friction = 1.0;
  return robotModelOf(arm);
}

double gravityTorque(double mass, double angle) { return mass * 9.81 * 0.5 * std::sin(angle); }

TEST(RobotFreeRun, RestsWhereDryFrictionHoldsIt) {
  const RobotModel model = pendulum(2.0);
  const auto held = [&](double short_of) {
    const RobotLog log = logOf(model, 2.0, 100.0, [&](double, VectorXd& q, VectorXd& v, VectorXd& effort) {
      q[0] = 0.4;
      v[0] = 0.0;
      effort[0] = gravityTorque(2.0, 0.4) - short_of;
    });
    return runFreely(model, log, {}).position;
  };
  EXPECT_LT((held(0.99).array() - 0.4).abs().maxCoeff(), 1e-12);
  // 0.05 N m beyond friction swing it through half a period, in which its weight falls by 9.81 cos(0.4) N m/rad.
  const Eigen::MatrixXd swung = held(1.05);
  EXPECT_NEAR(swung(swung.rows() - 1, 0), 0.4 - 2.0 * 0.05 / (9.81 * std::cos(0.4)), 2e-4);
}

TEST(RobotFreeRun, BeginsAnewAfterAGap) {
  const RobotModel model = pendulum(2.0);
  RobotLog log = logOf(model, 2.0, 100.0, [&](double t, VectorXd& q, VectorXd& v, VectorXd& effort) {
    q[0] = t < 1.0 ? 0.4 : -0.2;
    v[0] = 0.0;
    effort[0] = gravityTorque(2.0, q[0]);
  });
  for (double& t : log.time) t += t < 1.0 ? 0.0 : 30.0;
  EXPECT_LT(runFreely(model, log, {}).rms[0], 1e-12);
}

TEST(RobotFreeRun, ItsControllersCarryAWrongMass) {
  RobotModel model = pendulum(2.2);
  model.parameters[RobotRegressor(model.arm, friction::find(model.law)).frictionColumn(0)] = 0.0;
  const RobotLog log = logOf(model, 4.0, 100.0, [&](double, VectorXd& q, VectorXd& v, VectorXd& effort) {
    q[0] = 0.4;
    v[0] = 0.0;
    effort[0] = gravityTorque(2.0, 0.4);
  });
  const RobotFreeRun alone = runFreely(model, log, {});
  EXPECT_LT(alone.near_s[0], 0.5);
  const std::vector<JointGains> gains{{200.0, 40.0, 0.0}};
  const double at = runFreely(model, log, gains).position(log.rows() - 1, 0);
  // At rest the spring of the controller carries what the weight is more: 200 (0.4 - q) = m' g l sin q - m g l sin 0.4.
  EXPECT_NEAR(200.0 * (0.4 - at), gravityTorque(2.2, at) - gravityTorque(2.0, 0.4), 1e-6);
  const std::vector<JointGains> with_integral{{200.0, 40.0, 300.0}};
  EXPECT_NEAR(runFreely(model, log, with_integral).position(log.rows() - 1, 0), 0.4, 1e-3);
}

TEST(RobotFreeRun, GainsAreOfItsJoints) {
  const RobotModel model = pendulum(2.0);
  const std::string name = loggedJoints(model.arm)[0].name;
  const auto read = [&](const std::string& joints) {
    return readJointGains(YamlNode::parse("format: simgap/joint-gains/1\njoints: " + joints, "gains.yaml"), model);
  };
  const std::vector<JointGains> gains = read("{" + name + ": {proportional_Nm_rad: 3, derivative_Nms_rad: 2}}");
  ASSERT_EQ(gains.size(), 1u);
  EXPECT_EQ(gains[0].proportional, 3.0);
  EXPECT_EQ(gains[0].derivative, 2.0);
  EXPECT_EQ(gains[0].integral, 0.0);
  EXPECT_THROW(read("{}"), ConfigError);
  EXPECT_THROW(read("{" + name + ": {proportional_A_rad: 3}}"), ConfigError);
  EXPECT_THROW(read("{" + name + ": {proportional_Nm_rad: -3}}"), ConfigError);
  EXPECT_THROW(read("{" + name + ": {proportional_Nm_rad: 3}, other: {proportional_Nm_rad: 3}}"), ConfigError);
}

}  // namespace
}  // namespace simgap
