// Robots of tests/reality, whose torques come from Lagrange's equations: what a fit to their logs finds of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reality/robot_rig.h"
#include "simgap/core/error.h"
#include "simgap/exchange/exchange.h"
#include "simgap/fit/dynamics/robot_fit.h"
#include "support/files.h"
#include "support/robot_logs.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

TEST(RobotFit, RegressorGivesTheTorquesOfLagrange) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const reality::Robot robot = reality::randomRobot(seed, 2 + static_cast<int>(seed), seed % 2 == 0, true);
    const ArmModel arm = test::drawnArm(robot, 0);
    const InverseDynamics dynamics(arm);
    InverseDynamics::Workspace work = dynamics.workspace();
    const Index n = std::ssize(robot.links);
    RegressorMatrix y(n, dynamics.parameters());
    VectorXd q(n), v(n), a(n);
    const std::vector<std::size_t> links = test::linksOfJoints(arm);
    for (Index k = 0; k < n; ++k) {
      q[k] = 0.3 * std::sin(3.0 * static_cast<double>(k) + static_cast<double>(seed));
      v[k] = std::cos(2.0 * static_cast<double>(k));
      a[k] = 3.0 * std::sin(5.0 * static_cast<double>(k) + 1.0);
    }
    dynamics.regressor({q.data(), q.data() + n}, {v.data(), v.data() + n}, {a.data(), a.data() + n}, arm.gravity, work,
                       y);
    VectorXd of_links(n), ours(n), q_links(n), v_links(n), a_links(n);
    of_links = y * dynamics.parametersOf(arm);
    for (Index k = 0; k < n; ++k) {
      const Index link = links[k];
      ours[link] = of_links[k];
      q_links[link] = q[k];
      v_links[link] = v[k];
      a_links[link] = a[k];
    }
    const VectorXd theirs = reality::rigidTorques(robot, q_links, v_links, a_links);
    // The central differences of the other side leave some 1e-9 of the mass matrix.
    EXPECT_LT((ours - theirs).norm(), 1e-7 * theirs.norm()) << "seed " << seed;
  }
}

/// A joint that follows may stand before the one that leads it: two bodies, q_1 = 2 q_2 + 0.3, whose torque is that of
/// the potential and kinetic energy by q_2.
TEST(RobotFit, AFollowerMayComeBeforeItsLeader) {
  reality::Robot chain = reality::randomRobot(5, 2, false, false);
  ArmModel coupled = test::drawnArm(chain, 0);
  coupled.joints[0].leader = 1;
  coupled.joints[0].coupling_ratio = 2.0;
  coupled.joints[0].coupling_offset = 0.3;
  const InverseDynamics dynamics(coupled), free(test::drawnArm(chain, 0));
  ASSERT_EQ(dynamics.joints().size(), 1u);
  InverseDynamics::Workspace work = dynamics.workspace(), free_work = free.workspace();
  RegressorMatrix y(1, dynamics.parameters()), y_free(2, free.parameters());
  const double q = 0.4, v = -0.7, a = 1.3;
  dynamics.regressor(std::span(&q, 1), std::span(&v, 1), std::span(&a, 1), coupled.gravity, work, y);
  const double both[3][2] = {{2.0 * q + 0.3, q}, {2.0 * v, v}, {2.0 * a, a}};
  free.regressor(both[0], both[1], both[2], coupled.gravity, free_work, y_free);
  const VectorXd torques = y_free * free.parametersOf(coupled);
  EXPECT_NEAR((y * dynamics.parametersOf(coupled))[0], 2.0 * torques[0] + torques[1], 1e-12);
}

TEST(RobotFit, BaseParametersOfAPendulum) {
  reality::Robot pendulum;
  reality::RobotLink link;
  link.axis = Eigen::Vector3d::UnitX();
  link.inertia = Eigen::Matrix3d::Identity();
  pendulum.links = {link};
  const ArmModel arm = test::drawnArm(pendulum, 0);
  const RobotRegressor regressor(arm, friction::find("coulomb"));
  const BaseParameters base = baseParameters(regressor, arm);
  // Gravity along z about x: the first moments across the axis and the inertia about it, which is also the rotor's.
  const std::vector<std::string> names = {"j1.offset", "j1.tau_c", "j1.k_v", "link1.mc_y", "link1.mc_z", "link1.I_xx"};
  EXPECT_EQ(base.names, names);
  EXPECT_EQ(base.texts.back(), "link1.I_xx + j1.rotor");
  EXPECT_EQ(base.without_effect.size(), 7u);  // m, mc_x and five of the inertia
}

TEST(RobotFit, BaseParametersMakeUpAllTorques) {
  const ArmModel arm = test::drawnArm(reality::randomRobot(7, 5, true, true), 0);
  const RobotRegressor regressor(arm, friction::find("coulomb"));
  const BaseParameters base = baseParameters(regressor, arm);
  const RobotMotion motion{
      {0.1, -0.2, 0.15, 0.05, -0.1}, {1.0, -2.0, 0.5, 0.3, 0.7}, {3.0, 1.0, -4.0, 2.0, 5.0}, {1, -1, 1, 1, 1}};
  const std::vector<StribeckCurve> curves(5);
  RobotRegressor::Workspace work = regressor.workspace();
  RegressorMatrix y(5, regressor.columns());
  regressor.rows(motion, curves, work, y);
  const VectorXd all = VectorXd::LinSpaced(regressor.columns(), 0.5, 2.0);
  const VectorXd torque = y * all, again = y(Eigen::all, base.columns) * (base.combination * all);
  EXPECT_LT((torque - again).norm(), 1e-5 * torque.norm());  // factors below 1e-7 are left out
  EXPECT_LT(std::ssize(base.columns), regressor.columns());
}

TEST(RobotFit, LogCholeskyHoldsTheBody) {
  const ArmModel arm = test::drawnArm(reality::randomRobot(3, 3, false, false), 0);
  const VectorXd all = InverseDynamics(arm).parametersOf(arm);
  const BodyParameters pi = all.segment<kBodyParameters>(kBodyParameters);
  const LogCholesky theta = logCholeskyOf(pi);
  BodyJacobian slopes;
  EXPECT_LT((bodyOf(theta, &slopes) - pi).norm(), 1e-12 * pi.norm());
  EXPECT_GT(smallestMoment(pi), 0.0);
  constexpr double kStep = 1e-6;
  for (Index k = 0; k < kBodyParameters; ++k) {
    LogCholesky before = theta, after = theta;
    before[k] -= kStep;
    after[k] += kStep;
    const BodyParameters slope = (bodyOf(after) - bodyOf(before)) / (2.0 * kStep);
    EXPECT_LT((slopes.col(k) - slope).norm(), 1e-7 * (1.0 + slope.norm())) << k;
  }
}

TEST(RobotFit, APointMassIsMadeThick) {
  MassProperties point;
  point.mass = 2.0;
  point.centre_of_mass = {0.1, 0.0, 0.3};
  const BodyParameters pi = parametersOf(point), thick = bodyOf(logCholeskyOf(pi));
  EXPECT_GT(smallestMoment(thick), 0.0);
  EXPECT_LT((thick - pi).norm(), 1e-5);
}

/// Without noise every base parameter is the robot's own, but for what derivatives of a sampled motion leave.
TEST(RobotFit, FindsARobotWithoutNoise) {
  const reality::Robot robot = reality::randomRobot(11, 3, false, false);
  reality::RobotRigOptions rig;
  rig.torque_noise = 0.0;
  rig.position_quantum = 0.0;
  rig.stops = false;
  rig.rate = 200.0;
  const ArmModel arm = test::drawnArm(robot, 1);
  const RobotFit found = fitRobot(arm, test::robotLog(arm, reality::recordRobot(robot, rig, 1)), {});
  const VectorXd truth = test::trueBase(robot, arm);
  for (std::size_t k = 0; k < found.fit.base.size(); ++k) {
    const Estimate& e = found.fit.base[k].estimate;
    const double size = std::max(0.02, std::abs(truth[k]));
    EXPECT_NEAR(e.value, truth[k], 0.01 * size + 4.0 * e.sd) << e.name;  // smoothing errs, too
  }
  for (std::size_t c = 0; c < robot.links.size(); ++c) {
    EXPECT_LT(found.heldout.model[c], 0.01) << "joint " << c;
    EXPECT_GT(found.heldout.alone[c], 5.0 * found.heldout.model[c]) << "joint " << c;
  }
}

TEST(RobotFit, BodiesThatItFindsCanExist) {
  const reality::Robot robot = reality::randomRobot(12, 4, true, true);
  const ArmModel arm = test::drawnArm(robot, 2);
  const RobotFit found = fitRobot(arm, test::robotLog(arm, reality::recordRobot(robot, {}, 2)), {});
  const RobotRegressor regressor(arm, friction::find("coulomb"));
  for (std::size_t b = 0; b < regressor.bodies(); ++b) {
    const BodyParameters pi = found.model.parameters.segment<kBodyParameters>(regressor.bodyColumn(b));
    EXPECT_GT(smallestMoment(pi), 0.0) << b;
  }
  for (std::size_t c = 0; c < regressor.coordinates(); ++c) {
    EXPECT_GE(found.model.parameters[regressor.rotorColumn(c)], 0.0);
    EXPECT_GE(found.model.parameters[regressor.frictionColumn(c)], 0.0);
  }
  // Rests are left out and counted.
  EXPECT_GT(test::robotLog(arm, reality::recordRobot(robot, {}, 2)).joints[0].resting, 100u);
}

// Levenberg's and Marquardt's steps were not at the end of it after 300 iterations.
TEST(RobotFit, ANarrowValleyOfBodiesIsFollowedToItsEnd) {
  constexpr std::uint64_t kSeed = 3131;
  reality::RobotRigOptions rig;
  rig.duration = 40.0;
  const reality::Robot robot = reality::randomRobot(kSeed, 2, false, false);
  const ArmModel arm = test::drawnArm(robot, kSeed);
  EXPECT_NO_THROW(fitRobot(arm, test::robotLog(arm, reality::recordRobot(robot, rig, 3 * kSeed)), {}));
}

TEST(RobotFit, ModelReadsBackAsItWas) {
  const reality::Robot robot = reality::randomRobot(13, 2, false, false);
  const ArmModel arm = test::drawnArm(robot, 3);
  reality::RobotRigOptions rig;
  rig.current = true;
  const RobotLog log = test::robotLog(arm, reality::recordRobot(robot, rig, 3, {10.0, 5.0}));
  RobotFitOptions options;
  options.law = "stribeck";
  options.torque_constants = {10.0, 5.0};
  const RobotFit found = fitRobot(arm, log, options);
  const RobotModel read = readRobotModel(YamlNode::parse(writeRobotModel(found.model), "model.yaml"));
  EXPECT_EQ(predictEfforts(read, log), predictEfforts(found.model, log));
  EXPECT_EQ(writeRobotModel(read), writeRobotModel(found.model));
  ASSERT_EQ(read.presliding.size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) EXPECT_EQ(loggedJoints(read)[c].presliding, read.presliding[c]);
  ASSERT_EQ(read.heldout_sd.size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_NEAR(read.heldout_sd[c], found.heldout.sd[c], 1e-5 * found.heldout.sd[c]);
    EXPECT_GT(read.heldout_sd[c], 0.8 * found.fit.noise[c]);
    EXPECT_LT(read.heldout_sd[c], 1.5 * found.fit.noise[c]);
  }
}

/// Files of before do not say what their robot leaves of data it was not fitted to.
TEST(RobotFit, AModelWithoutHeldOutDeviationsIsRead) {
  const RobotModel model = robotModelOf(test::drawnArm(reality::randomRobot(13, 2, false, false), 3));
  const std::string text = writeRobotModel(model);
  EXPECT_EQ(text.find("heldout_sd"), std::string::npos);
  EXPECT_TRUE(readRobotModel(YamlNode::parse(text, "model.yaml")).heldout_sd.empty());
}

/// Joints are told by their names, not by their places: constants of one joint went to another.
TEST(RobotFit, AModelWhoseJointsAreInAnotherOrderIsRefused) {
  std::string text = writeRobotModel(robotModelOf(test::drawnArm(reality::randomRobot(13, 2, false, false), 3)));
  const std::size_t first = text.find("name: j1"), second = text.find("name: j2");
  text[first + 7] = '2', text[second + 7] = '1';
  EXPECT_THAT(test::errorOf([&] { readRobotModel(YamlNode::parse(text, "model.yaml")); }),
              testing::HasSubstr("found j2, expected j1"));
}

/// Currents are torques over constants: what is found of the robot is the same.
TEST(RobotFit, CurrentsWithTheirConstants) {
  const reality::Robot robot = reality::randomRobot(14, 3, false, false);
  const ArmModel arm = test::drawnArm(robot, 4);
  reality::RobotRigOptions rig;
  rig.current = true;
  const std::string csv = reality::recordRobot(robot, rig, 4, {12.0, 8.0, 4.0});
  RobotFitOptions options;
  options.torque_constants = {12.0, 8.0, 4.0};
  const RobotFit currents = fitRobot(arm, test::robotLog(arm, csv), options);
  rig.current = false;
  const RobotFit torques = fitRobot(arm, test::robotLog(arm, reality::recordRobot(robot, rig, 4)), {});
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(currents.heldout.model[c], torques.heldout.model[c], 1e-3);
  for (std::size_t k = 0; k < currents.fit.base.size(); ++k) {
    const Estimate &a = currents.fit.base[k].estimate, &b = torques.fit.base[k].estimate;
    EXPECT_NEAR(a.value, b.value, 0.1 * b.sd + 1e-6) << a.name;  // five digits in the log
  }
}

/// The log says nothing of a joint that is held, and what it says of the others stays right.
TEST(RobotFit, AJointThatNeverMoves) {
  reality::Robot robot = reality::randomRobot(17, 3, false, false);
  robot.links[1].lower = 0.4;
  robot.links[1].upper = 0.4;
  const ArmModel arm = test::drawnArm(robot, 7);
  const RobotFit found = fitRobot(arm, test::robotLog(arm, reality::recordRobot(robot, {}, 7)), {});
  EXPECT_TRUE(std::isnan(found.heldout.model[1]));
  EXPECT_LT(found.heldout.model[0], 0.03);
  EXPECT_LT(found.heldout.model[2], 0.03);
  EXPECT_EQ(std::ranges::count(found.warnings, "joint j2 does not move in any row: nothing is known of its drive"), 1);
  const Estimate& offset = found.fit.base[3].estimate;
  EXPECT_EQ(offset.name, "j2.offset");
  EXPECT_FALSE(offset.identifiable);
}

std::string refusal(const ArmModel& arm, const std::string& csv, const RobotFitOptions& options = {}) {
  try {
    fitRobot(arm, test::robotLog(arm, csv), options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(RobotFit, GravityThatContradictsTheLogIsRefused) {
  const reality::Robot robot = reality::randomRobot(15, 4, false, false);
  ArmModel arm = test::drawnArm(robot, 5);
  const std::string csv = reality::recordRobot(robot, {}, 5);
  EXPECT_EQ(refusal(arm, csv), "no error");
  arm.gravity = {0.0, 0.0, 9.81};
  EXPECT_NE(refusal(arm, csv).find("the torques are those of gravity along"), std::string::npos) << refusal(arm, csv);
  arm.gravity = {9.81, 0.0, 0.0};
  EXPECT_NE(refusal(arm, csv).find("but the robot has (9.8, 0.0, 0.0)"), std::string::npos) << refusal(arm, csv);
}

/// Of a planar arm no joint feels gravity along the axes: what they do feel is judged.
TEST(RobotFit, GravityIsCheckedAsFarAsJointsFeelIt) {
  reality::Robot robot = reality::randomRobot(15, 3, false, false);
  for (reality::RobotLink& link : robot.links) {
    link.axis = Eigen::Vector3d::UnitY();
    link.origin.linear().setIdentity();
  }
  ArmModel arm = test::drawnArm(robot, 5);
  const std::string csv = reality::recordRobot(robot, {}, 5);
  EXPECT_EQ(refusal(arm, csv), "no error");
  arm.gravity = {0.0, 4.0, -9.0};
  EXPECT_EQ(refusal(arm, csv), "no error");
  arm.gravity = {0.0, 0.0, 9.81};
  EXPECT_NE(refusal(arm, csv).find("as far as its joints feel it, but the robot has"), std::string::npos)
      << refusal(arm, csv);
  arm.gravity = {0.0, 9.81, 0.0};
  EXPECT_NE(refusal(arm, csv).find("as far as its joints feel it, but the robot has"), std::string::npos)
      << refusal(arm, csv);
}

/// A cord holds the last, light links up with four times what they weigh: the joints that carry the arm know where down
/// is.
TEST(RobotFit, WhatPullsAtAWristIsNoOtherGravity) {
  const reality::Robot robot = reality::randomRobot(15, 5, false, false);
  const ArmModel arm = test::drawnArm(robot, 5);
  RobotLog log = test::robotLog(arm, reality::recordRobot(robot, {}, 5));
  const InverseDynamics dynamics(arm);
  InverseDynamics::Workspace work = dynamics.workspace();
  RegressorMatrix y(5, dynamics.parameters());
  std::vector<double> q(5), still(5);
  for (std::size_t i = 0; i < log.rows(); ++i) {
    for (std::size_t c = 0; c < 5; ++c) q[c] = log.joints[c].position[i];
    dynamics.regressor(q, still, still, arm.gravity, work, y);
    const VectorXd weight = y * dynamics.parametersOf(arm);
    for (const Index c : {2, 3, 4}) log.joints[c].effort[i] -= 4.0 * weight[c];
  }
  EXPECT_NO_THROW(fitRobot(arm, log, {}));
}

/// Joints about the vertical feel no weight: what the log says of the plane contradicts nothing.
TEST(RobotFit, ARobotThatFeelsNoWeightIsNotRefused) {
  reality::Robot robot = reality::randomRobot(17, 3, false, false);
  for (reality::RobotLink& link : robot.links) {
    link.axis = Eigen::Vector3d::UnitZ();
    link.origin.linear().setIdentity();
  }
  const ArmModel arm = test::drawnArm(robot, 5);
  EXPECT_EQ(refusal(arm, reality::recordRobot(robot, {}, 5)), "no error");
}

TEST(RobotFit, LogsThatCannotAnswerAreRefused) {
  const reality::Robot robot = reality::randomRobot(16, 2, false, false);
  const ArmModel arm = test::drawnArm(robot, 0);
  reality::RobotRigOptions rig;
  rig.duration = 12.0;
  const std::string csv = reality::recordRobot(robot, rig, 6);
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = csv;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_NE(refusal(arm, replaced("j2_rad", "knee_rad")).find("found no position of joint j2, expected"),
            std::string::npos);
  EXPECT_NE(refusal(arm, replaced("torque_j2_Nm", "spare_Nm")).find("found no torque or current of joint j2"),
            std::string::npos);
  EXPECT_NE(refusal(arm, replaced("torque_j2_Nm", "current_j2_A")).find("expected one kind for all joints"),
            std::string::npos);
  EXPECT_NE(refusal(arm, replaced("j2_rad", "j2_deg")).find("no error"), std::string::npos);
  std::string far = csv;
  const std::size_t line = far.find('\n', far.find('\n') + 1) + 1;
  const std::size_t cell = far.find(',', line) + 1;
  far.replace(cell, far.find(',', cell) - cell, "9.5");
  EXPECT_NE(refusal(arm, far).find("expected a position within the limits of joint j1"), std::string::npos)
      << refusal(arm, far);
  RobotFitOptions constants;
  constants.torque_constants = {1.0, 2.0};
  EXPECT_NE(refusal(arm, csv, constants).find("expected constants with currents only"), std::string::npos);
  rig.current = true;
  EXPECT_NE(refusal(arm, reality::recordRobot(robot, rig, 6, {2.0, 3.0})).find("expected --torque-constants too"),
            std::string::npos);
}

}  // namespace
}  // namespace simgap
