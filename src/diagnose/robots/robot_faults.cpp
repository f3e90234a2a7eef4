#include "robot_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/dynamics/base_fit.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Rows at the largest or the smallest effort, where many share it: a drive or its converter has cut them off.
void leaveOutClipped(RobotJointLog& joint, std::vector<DataFault>& faults) {
  constexpr double kMany = 0.01, kMost = 0.4;
  const auto [low, high] = std::ranges::minmax(joint.effort);
  std::size_t clipped = 0, first = 0, last = 0;
  const auto isCut = [&, lowest = low, highest = high](std::size_t i) {
    const bool again = (i > 0 && joint.effort[i - 1] == joint.effort[i]) ||
                       (i + 1 < joint.effort.size() && joint.effort[i + 1] == joint.effort[i]);
    return again && (joint.effort[i] == lowest || joint.effort[i] == highest);
  };
  for (std::size_t i = 0; i < joint.effort.size(); ++i) {
    if (!isCut(i)) continue;
    if (clipped++ == 0) first = i + 1;
    last = i + 1;
  }
  const auto share = static_cast<double>(clipped) / static_cast<double>(joint.effort.size());
  if (share < kMany || share > kMost) return;
  for (std::size_t i = 0; i < joint.effort.size(); ++i) {
    if (isCut(i)) joint.moves[i] = false;
  }
  faults.push_back(
      {"effort of " + joint.name,
       fmt::format("the effort of {} stands at its largest or smallest value in {} rows: it is cut off there, "
                   "and they were left out",
                   joint.name, clipped),
       first, last, clipped, true});
}

}  // namespace

std::vector<DataFault> findRobotFaults(const RobotRegressor& regressor, const VectorXd& given,
                                       const std::vector<StribeckCurve>& curves, RobotLog& log) {
  constexpr double kOpposite = -0.5;  // correlation of measured and expected efforts
  std::vector<DataFault> faults;
  for (RobotJointLog& joint : log.joints) {
    const auto [low, high] = std::ranges::minmax(joint.effort);
    const bool moves = std::ranges::any_of(joint.moves, [](bool moving) { return moving; });
    if (moves && high <= low) {
      faults.push_back({"effort of " + joint.name,
                        fmt::format("the effort of {} is {:.4g} in every row although it moves: its channel is stuck",
                                    joint.name, low),
                        0, 0, joint.effort.size(), false});
    } else {
      leaveOutClipped(joint, faults);
    }
  }
  if (given.size() == 0) return faults;
  const Eigen::MatrixXd expected = predictTorques(log, regressor, given, curves);
  for (std::size_t c = 0; c < log.joints.size(); ++c) {
    std::vector<double> measured, modelled;
    for (std::size_t i = 0; i < log.rows(); ++i) {
      if (!log.usable[i] || !log.joints[c].moves[i]) continue;
      measured.push_back(log.joints[c].effort[i]);
      modelled.push_back(expected(static_cast<Index>(i), static_cast<Index>(c)));
    }
    if (measured.size() < 50 || correlation(measured, modelled) > kOpposite) continue;
    faults.push_back({"effort of " + log.joints[c].name,
                      fmt::format("the effort of {} has the opposite sign of what its motion asks for: turn it round "
                                  "(--map), or the joint's axis",
                                  log.joints[c].name),
                      0, 0, measured.size(), false});
  }
  return faults;
}

void requireLogOfRobot(const DynamicsData& data, const std::vector<JointSums>& sums, const VectorXd& given,
                       const std::vector<double>& constants, const std::string& file) {
  const VectorXd x = data.base.combination * given;
  double moving = 0.0, worse = 0.0, largest = 0.0;
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const double squares = constants[c] * constants[c] * sums[c].effortSquares();
    if (!(squares > 0.0)) continue;
    const double error = std::sqrt(squaredError(sums[c], data.base.acts[c], x, constants[c]) / squares);
    moving += 1.0;
    worse += error > 1.0 ? 1.0 : 0.0;
    largest = std::max(largest, error);
  }
  if (moving == 0.0 || 2.0 * worse <= moving) return;
  throw DataError(
      fmt::format("{}: the robot's model errs by more than the whole effort at {:.0f} of {:.0f} joints (up to "
                  "{:.0f} %), expected a log of this robot",
                  file, worse, moving, 100.0 * largest));
}

}  // namespace simgap
