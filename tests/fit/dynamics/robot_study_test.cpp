// What fit-dynamics promises, counted on robots that are known (docs/studies/robots.md).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reality/robot_rig.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/dynamics/dynamics_sums.h"
#include "simgap/fit/dynamics/robot_fit.h"
#include "support/robot_logs.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

struct RobotStudy {
  int covered = 0, intervals = 0, open = 0;
  std::vector<double> ratios;      ///< error of the found model on another trajectory, of the true model's
  std::vector<double> drawn;       ///< error of the file's bodies with their true drives, of the true model's
  std::vector<double> alone, all;  ///< held out
};

double totalError(const RobotLog& log, const RobotRegressor& regressor, const VectorXd& parameters) {
  const std::vector<StribeckCurve> curves(regressor.coordinates());
  const Eigen::MatrixXd predicted = predictTorques(log, regressor, parameters, curves);
  double sum = 0.0;
  for (std::size_t c = 0; c < regressor.coordinates(); ++c) sum += std::pow(relativeError(log, c, predicted), 2);
  return std::sqrt(sum / static_cast<double>(regressor.coordinates()));
}

void addRobot(std::uint64_t seed, const reality::RobotRigOptions& rig, RobotStudy& study) {
  const int joints = 2 + static_cast<int>(seed % 6);
  const reality::Robot robot = reality::randomRobot(seed, joints, seed % 2 == 0, seed % 3 == 0);
  const ArmModel arm = test::drawnArm(robot, seed);
  const RobotFit found = fitRobot(arm, test::robotLog(arm, reality::recordRobot(robot, rig, 2 * seed)), {});
  const VectorXd truth = test::trueBase(robot, arm);
  for (Index k = 0; k < truth.size(); ++k) {
    const Estimate& e = found.fit.base[k].estimate;
    if (!e.identifiable) {
      ++study.open;
      continue;
    }
    ++study.intervals;
    study.covered += e.lower95 <= truth[k] && truth[k] <= e.upper95;
  }
  const RobotRegressor regressor(arm, friction::find("coulomb"));
  const RobotLog other = test::robotLog(arm, reality::recordRobot(robot, rig, 2 * seed + 1));
  const VectorXd true_all = test::trueParameters(robot, arm);
  VectorXd drawn = true_all;
  drawn.segment(regressor.bodyColumn(0), regressor.dynamics().parameters()) = regressor.dynamics().parametersOf(arm);
  const double best = totalError(other, regressor, true_all);
  study.ratios.push_back(totalError(other, regressor, found.model.parameters) / best);
  study.drawn.push_back(totalError(other, regressor, drawn) / best);
  for (std::size_t c = 0; c < found.heldout.model.size(); ++c) {
    study.alone.push_back(found.heldout.alone[c]);
    study.all.push_back(found.heldout.model[c]);
  }
}

void print(const char* name, const RobotStudy& s) {
  fmt::print(
      "{}: base parameters covered {} of {} ({:.1f} %), {} not determined; error on another trajectory of the "
      "true model's: median {:.3f}, 95 % {:.3f}, largest {:.3f}; the file's bodies: median {:.2f}; held out: "
      "alone {:.1f} %, all {:.2f} % (medians)\n",
      name, s.covered, s.intervals, 100.0 * s.covered / s.intervals, s.open, median(s.ratios), quantile(s.ratios, 0.95),
      *std::ranges::max_element(s.ratios), median(s.drawn), 100.0 * median(s.alone), 100.0 * median(s.all));
}

void study(const char* name, const reality::RobotRigOptions& rig, std::uint64_t first, int robots) {
  RobotStudy s;
  for (int k = 0; k < robots; ++k) addRobot(first + static_cast<std::uint64_t>(k), rig, s);
  print(name, s);
  EXPECT_GE(s.covered, 0.9 * s.intervals);
  EXPECT_LE(median(s.ratios), 1.1);
  EXPECT_LE(quantile(s.ratios, 0.9), 1.1);
}

TEST(SlowRobotStudy, AFewRobots) { study("a few", {}, 501, 6); }

/// What smoothing does to a motion that turns with a jerk is alike in all blocks.
TEST(SlowRobotStudy, AFewRobotsHeldOnTheirCourse) {
  reality::RobotRigOptions rig;
  rig.rate = 200.0;
  rig.log_velocity = true;
  rig.velocity_noise = 0.005;
  rig.torque_noise = 0.01;
  rig.tracking_error = 0.003;
  study("held back by 3 mrad at turns, velocities with 5 mrad/s of noise", rig, 601, 6);
}

TEST(SlowRobotStudy, EncodersAndStops) { study("encoders, stops, 60 s at 100 Hz", {}, 1, 60); }

TEST(SlowRobotStudy, CoarseEncoders) {
  reality::RobotRigOptions rig;
  rig.position_quantum = 3e-4;
  rig.torque_noise = 0.05;
  rig.correlation = 0.9;
  study("coarse encoders (3e-4 rad), 5 % of slow noise", rig, 101, 60);
}

TEST(SlowRobotStudy, MeasuredVelocities) {
  reality::RobotRigOptions rig;
  rig.log_velocity = true;
  rig.position_quantum = 1e-3;
  study("velocities with 2 mrad/s of noise", rig, 201, 60);
}

}  // namespace
}  // namespace simgap
