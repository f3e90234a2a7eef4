// The friction of robots of tests/reality: by the load, and over the speed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reality/robot_rig.h"
#include "simgap/fit/dynamics/robot_fit.h"
#include "support/robot_logs.h"

namespace simgap {
namespace {

using Eigen::Index;

/// The load stands in the law's own column, by the bodies that are found with it; the file's masses are off by a fifth.
TEST(RobotFriction, IsFoundThatGrowsWithTheLoad) {
  for (const std::uint64_t seed : {21, 22, 23}) {
    reality::Robot robot = reality::randomRobot(seed, 4, seed == 22, false);
    for (reality::RobotLink& link : robot.links) {
      link.load_friction = 0.15;
      link.more_static = 0.0;
    }
    const ArmModel arm = test::drawnArm(robot, seed);
    const RobotLog log = test::robotLog(arm, reality::recordRobot(robot, {}, seed));
    RobotFitOptions options;
    const RobotFit without = fitRobot(arm, log, options);
    options.law = "load-coulomb";
    const RobotFit found = fitRobot(arm, log, options);
    const RobotLog other = test::robotLog(arm, reality::recordRobot(robot, {}, seed + 100));
    const RobotRegressor regressor(arm, friction::find(options.law));
    double with_load = 0.0, plain = 0.0;
    for (std::size_t c = 0; c < robot.links.size(); ++c) {
      const Index n_c1 = regressor.frictionColumn(c);
      EXPECT_NEAR(found.model.parameters[n_c1], 0.15, 0.015 + 3.0 * found.model.sd[n_c1]) << seed << ", joint " << c;
      EXPECT_LT(found.heldout.model[c], 1.02 * without.heldout.model[c]) << seed << ", joint " << c;
      with_load += std::pow(relativeError(other, c, predictEfforts(found.model, other)), 2);
      plain += std::pow(relativeError(other, c, predictEfforts(without.model, other)), 2);
    }
    EXPECT_LT(with_load, 0.8 * plain) << seed;
  }
}

/// The best curve of a coarse grid leaves out what lies between: Coulomb's friction was in a third of its intervals.
TEST(RobotFriction, IsInItsIntervalsWhereTheCurveIsFound) {
  constexpr double kMoreStatic = 0.8, kShare = 0.11, kDelta = 1.4;  // of Coulomb's; of the top speed
  int covered = 0, intervals = 0;
  for (const std::uint64_t seed : {31, 32, 33, 34}) {
    reality::Robot robot = reality::randomRobot(seed, 4, seed % 2 == 0, false);
    for (reality::RobotLink& link : robot.links) link.more_static = 0.0;
    const ArmModel arm = test::drawnArm(robot, seed);
    RobotLog log = test::robotLog(arm, reality::recordRobot(robot, {}, seed));
    const std::vector<std::size_t> links = test::linksOfJoints(arm);
    for (std::size_t c = 0; c < links.size(); ++c) {
      RobotJointLog& joint = log.joints[c];
      double top = 0.0;
      for (const double v : joint.velocity) top = std::max(top, std::abs(v));
      for (std::size_t i = 0; i < log.rows(); ++i) {
        const double fades = std::exp(-std::pow(std::abs(joint.velocity[i]) / (kShare * top), kDelta));
        joint.effort[i] += kMoreStatic * robot.links[links[c]].coulomb * fades * joint.direction[i];
      }
    }
    RobotFitOptions options;
    options.law = "stribeck";
    const RobotFit found = fitRobot(arm, log, options);
    for (std::size_t c = 0; c < links.size(); ++c) {
      for (const auto& [name, truth] :
           {std::pair("tau_c", robot.links[links[c]].coulomb), std::pair("k_v", robot.links[links[c]].viscous)}) {
        const std::string wanted = fmt::format("{}.{}", log.joints[c].name, name);
        const auto base =
            std::ranges::find_if(found.fit.base, [&](const BaseEstimate& b) { return b.estimate.name == wanted; });
        ASSERT_NE(base, found.fit.base.end()) << wanted;
        ++intervals;
        covered += base->estimate.lower95 <= truth && truth <= base->estimate.upper95;
      }
    }
  }
  EXPECT_EQ(intervals, 32);
  EXPECT_GE(covered, 28);
}

}  // namespace
}  // namespace simgap
