#include "simgap/fit/dynamics/robot_fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base_fit.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFewestBlocks = 10;

void checkLogOfRobot(const RobotLog& log, const RobotFitOptions& options) {
  const bool currents = log.joints.front().effort_unit == "A";
  if (options.torque_constants && !currents) {
    throw ConfigError(log.file + ": found torques and torque constants, expected constants with currents only");
  }
  if (!options.torque_constants && currents) {
    throw ConfigError(fmt::format(
        "{}: found currents, expected --torque-constants too, one for each of {} joints [Nm/A]: currents alone tell "
        "constants and masses only as products",
        log.file, log.joints.size()));
  }
  if (options.torque_constants && options.torque_constants->size() != log.joints.size()) {
    throw ConfigError(fmt::format("found {} torque constants, expected {}: one for each joint, in the robot's order",
                                  options.torque_constants->size(), log.joints.size()));
  }
  if (log.blocks.size() < kFewestBlocks) {
    throw DataError(fmt::format("{}: found {} rows in {} blocks, expected a log of at least {} blocks of 50 rows",
                                log.file, log.rows(), log.blocks.size(), kFewestBlocks));
  }
  const bool moves = std::ranges::any_of(log.joints, [](const RobotJointLog& joint) {
    return std::ranges::any_of(joint.moves, [](bool moving) { return moving; });
  });
  if (!moves) throw DataError(log.file + ": no joint moves in any row, expected motion: nothing can be found");
}

/// \throws DataError: gravity of the log points away from that of the file.
void checkGravity(const ArmModel& arm, const RobotLog& log) {
  constexpr double kFar = 0.5;  // cosine: 60 degrees
  const std::optional<Vector3d> found = gravityOfLog(arm, log);
  if (!found || arm.gravity.norm() == 0.0) return;
  if (found->normalized().dot(arm.gravity.normalized()) > kFar) return;
  const Vector3d seen = arm.gravity.norm() * found->normalized();
  throw DataError(fmt::format(
      "{}: the torques are those of gravity along ({:.1f}, {:.1f}, {:.1f}) m/s^2, but the robot has ({:.1f}, {:.1f}, "
      "{:.1f}), expected the same direction: say how it stood with --gravity, or turn the sign of the efforts (--map)",
      log.file, seen.x(), seen.y(), seen.z(), arm.gravity.x(), arm.gravity.y(), arm.gravity.z()));
}

/// Of each joint the curve with which all columns that act on it leave least, among speeds that it reaches.
std::vector<StribeckCurve> findCurves(const RobotLog& log, const RobotRegressor& regressor,
                                      const BaseParameters& base) {
  std::vector<StribeckCurve> best(regressor.coordinates());
  if (!regressor.law().hasStribeck()) return best;
  std::vector<double> lowest(best.size(), INFINITY), top;
  for (const RobotJointLog& joint : log.joints) {
    double speed = 0.0;
    for (const double v : joint.velocity) speed = std::max(speed, std::abs(v));
    top.push_back(speed);
  }
  const ArmModel none;
  const DynamicsSums no_sums;
  const DynamicsData data{none, regressor, base, no_sums};
  for (const double delta : {1.0, 2.0}) {
    for (double share = 0.01; share < 0.7; share *= 2.0) {
      std::vector<StribeckCurve> curves;
      for (const double speed : top) curves.push_back({share * speed, delta});
      const DynamicsSums sums = sumDynamics(log, regressor, base, curves);
      const std::vector<JointSums> all = sums.total(std::vector<bool>(sums.blocks.size(), true));
      const BaseSolution solution = solveBase(data, all, std::vector<double>(best.size(), 1.0));
      for (std::size_t c = 0; c < best.size(); ++c) {
        if (solution.variance[c] >= lowest[c]) continue;
        lowest[c] = solution.variance[c];
        best[c] = curves[c];
      }
    }
  }
  return best;
}

/// Stretches of four neighbouring blocks go to folds in turn: what is alike over seconds is held out together.
std::vector<int> foldsOverBlocks(std::size_t blocks) {
  constexpr std::size_t kFolds = 5, kStretch = 4;
  const std::size_t stretch = blocks >= 2 * kFolds * kStretch ? kStretch : 1;
  std::vector<int> folds;
  for (std::size_t b = 0; b < blocks; ++b) folds.push_back(static_cast<int>(b / stretch % kFolds));
  return folds;
}

std::vector<std::string> warningsOf(const RobotLog& log, const RobotFit& found) {
  std::vector<std::string> warnings = log.warnings;
  for (std::size_t c = 0; c < log.joints.size(); ++c) {
    if (found.fit.rows[c] > 0.0) continue;
    warnings.push_back(
        fmt::format("joint {} does not move in any row: nothing is known of its drive", log.joints[c].name));
  }
  std::vector<std::string> open;
  for (const BaseEstimate& base : found.fit.base) {
    if (!base.estimate.identifiable) open.push_back(base.estimate.name);
  }
  if (!open.empty()) {
    warnings.push_back(
        fmt::format("these motions do not determine {}: the model has the file's values there", fmt::join(open, ", ")));
  }
  return warnings;
}

}  // namespace

RobotFit fitRobot(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options) {
  checkLogOfRobot(log, options);
  const RobotRegressor regressor(arm, friction::find(options.law));
  const BaseParameters base = baseParameters(regressor, arm);
  checkGravity(arm, log);
  const bool currents = log.joints.front().effort_unit == "A";
  RobotFit found;
  found.names = regressor.names();
  found.units = regressor.units();
  found.without_effect = base.without_effect;
  found.model.curves = findCurves(log, regressor, base);
  const DynamicsSums sums = sumDynamics(log, regressor, base, found.model.curves);
  const DynamicsData data{arm, regressor, base, sums};
  const std::vector<double> constants = options.torque_constants.value_or(std::vector<double>(log.joints.size(), 1.0));
  found.fit = fitDynamics(data, constants);
  if (!found.fit.converged) {
    throw NumericsError("the search for bodies that can exist did not converge: is the log of this robot?");
  }
  found.heldout = crossValidate(data, constants, foldsOverBlocks(log.blocks.size()));
  if (log.session_names.size() > 1) {
    std::vector<int> of_session;
    for (const Block& block : log.blocks) of_session.push_back(log.session[block.begin]);
    found.over_logs = crossValidate(data, constants, of_session);
  }
  found.model.arm = armWith(arm, regressor, found.fit.model.parameters);
  found.model.law = options.law;
  found.model.currents = currents;
  if (currents) found.model.torque_constants = found.fit.model.torque_constants;
  found.model.parameters = found.fit.model.parameters;
  found.model.sd = found.fit.sd;
  found.warnings = warningsOf(log, found);
  return found;
}

}  // namespace simgap
