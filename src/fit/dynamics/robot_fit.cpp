#include "simgap/fit/dynamics/robot_fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "gravity_check.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/dynamics/base_fit.h"

namespace simgap {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kFewestBlocks = 10;

void checkLogOfRobot(const RobotLog& log, const RobotFitOptions& options) {
  const bool currents = log.joints.front().effort_unit == "A";
  if (options.torque_constants && !currents) {
    throw ConfigError(log.file + ": found torques and torque constants, expected constants with currents only");
  }
  if (!options.torque_constants && !options.payload && currents) {
    throw ConfigError(fmt::format(
        "{}: found currents, expected --torque-constants too, one for each of {} joints [Nm/A], or --payload and "
        "--loaded-log: currents alone tell constants and masses only as products",
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
  const std::optional<LoggedGravity> found = gravityOfLog(arm, log);
  const bool currents = log.joints.front().effort_unit == "A";
  if (!found || arm.gravity.norm() == 0.0 || !contradicts(*found, arm.gravity, currents)) return;
  const Vector3d seen = arm.gravity.norm() * found->direction.normalized();
  throw DataError(fmt::format(
      "{}: the torques are those of gravity along ({:.1f}, {:.1f}, {:.1f}) m/s^2{}, but the robot has ({:.1f}, {:.1f}, "
      "{:.1f}), expected the same direction: say how it stood with --gravity, or turn the sign of the efforts (--map)",
      log.file, seen.x(), seen.y(), seen.z(), found->felt.trace() < 2.5 ? " as far as its joints feel it" : "",
      arm.gravity.x(), arm.gravity.y(), arm.gravity.z()));
}

/// Some of the blocks, so that a search over curves goes through a few thousand rows.
std::vector<bool> thinnedBlocks(const RobotLog& log, const std::vector<bool>& used) {
  constexpr std::size_t kEnoughRows = 8000;
  std::size_t rows = 0, seen = 0;
  for (std::size_t b = 0; b < used.size(); ++b) rows += used[b] ? log.blocks[b].size() : 0;
  const std::size_t stride = 1 + rows / kEnoughRows;
  std::vector<bool> some = used;
  for (std::size_t b = 0; b < used.size(); ++b) some[b] = used[b] && seen++ % stride == 0;
  return some;
}

constexpr double kFastest = 0.7;           // speed of a curve, of the fastest of its joint
constexpr double kSteps[] = {1.41, 1.19};  // between a curve and those next to it: a half and a quarter of an octave

/// Curves of all joints that are faster, slower, steeper and flatter by a step.
std::vector<std::vector<StribeckCurve>> besideCurves(const std::vector<StribeckCurve>& curves, double step) {
  std::vector<std::vector<StribeckCurve>> all;
  for (const double factor : {step, 1.0 / step}) {
    for (double StribeckCurve::*part : {&StribeckCurve::v_s, &StribeckCurve::delta}) {
      std::vector<StribeckCurve>& others = all.emplace_back(curves);
      for (StribeckCurve& curve : others) curve.*part *= factor;
    }
  }
  return all;
}

std::vector<double> topSpeeds(const RobotLog& log) {
  std::vector<double> top;
  for (const RobotJointLog& joint : log.joints) {
    double speed = 1e-6;
    for (const double v : joint.velocity) speed = std::max(speed, std::abs(v));
    top.push_back(speed);
  }
  return top;
}

/// Of each joint the curve with which all columns that act on it leave least in some blocks, among speeds that it
/// reaches.
std::vector<StribeckCurve> findCurves(const RobotLog& log, const RobotRegressor& regressor, const BaseParameters& base,
                                      const std::vector<double>& constants, const std::vector<bool>& used,
                                      const ExtraColumn& load) {
  std::vector<StribeckCurve> best(regressor.coordinates());
  if (!regressor.law().hasStribeck()) return best;
  std::vector<double> lowest(best.size(), INFINITY);
  const std::vector<double> top = topSpeeds(log);
  const std::vector<bool> some = thinnedBlocks(log, used);
  const ArmModel no_arm;
  const auto look = [&](const std::vector<StribeckCurve>& curves) {
    const DynamicsSums sums = sumDynamics(log, regressor, base, curves, some, {}, load);
    const BaseSolution solution = solveBase({no_arm, regressor, base, sums}, sums.total(some), constants);
    for (std::size_t c = 0; c < best.size(); ++c) {
      if (solution.variance[c] >= lowest[c] || curves[c].v_s >= kFastest * top[c]) continue;
      lowest[c] = solution.variance[c];
      best[c] = curves[c];
    }
  };
  for (const double delta : {1.0, 2.0}) {
    for (double share = 0.01; share < kFastest; share *= 2.0) {
      std::vector<StribeckCurve> curves;
      for (const double speed : top) curves.push_back({share * speed, delta});
      look(curves);
    }
  }
  for (const double step : kSteps) {
    for (const std::vector<StribeckCurve>& curves : besideCurves(best, step)) look(curves);
  }
  return best;
}

/// Friction that grows with the load needs bodies that are to be found: those of the file say the load first, then
/// what some blocks say with it.
void findLoad(const ArmModel& arm, const RobotLog& log, const BaseParameters& base,
              const std::vector<double>& constants, const std::vector<bool>& used, const ExtraColumn& known,
              RobotRegressor& regressor) {
  constexpr int kRounds = 3;  // the load's share in friction is small, and so is what its error does
  for (int round = 0; round < kRounds && regressor.law().needsLoad(); ++round) {
    const std::vector<StribeckCurve> curves = findCurves(log, regressor, base, constants, used, known);
    const DynamicsSums sums = sumDynamics(log, regressor, base, curves, used, {}, known);
    regressor.setLoad(fittedParameters({arm, regressor, base, sums}, constants, used));
  }
}

/// Stretches of four neighbouring blocks go to folds in turn: what is alike over seconds is held out together.
std::vector<int> foldsOverBlocks(std::size_t blocks) {
  constexpr std::size_t kFolds = 5, kStretch = 4;
  const std::size_t stretch = blocks >= 2 * kFolds * kStretch ? kStretch : 1;
  std::vector<int> folds;
  for (std::size_t b = 0; b < blocks; ++b) folds.push_back(static_cast<int>(b / stretch % kFolds));
  return folds;
}

std::vector<std::string> warningsOf(const ArmModel& file, const RobotLog& log, const RobotFit& found) {
  std::vector<std::string> warnings = log.warnings;
  for (std::size_t c = 0; c < log.joints.size(); ++c) {
    if (found.fit.rows[c] > 0.0) continue;
    warnings.push_back(
        fmt::format("joint {} does not move in any row: nothing is known of its drive", log.joints[c].name));
  }
  constexpr double kMuch = 0.4;  // of the effort
  for (std::size_t c = 0; c < log.joints.size(); ++c) {
    if (!(found.heldout.model[c] > kMuch)) continue;
    warnings.push_back(
        fmt::format("of joint {} the model of all joints misses {:.0f} % of the effort: are its columns those of this "
                    "joint, in the "
                    "units that they say?",
                    log.joints[c].name, 100.0 * found.heldout.model[c]));
  }
  constexpr double kTimes = 5.0;
  for (std::size_t b = 0; b < file.bodies.size(); ++b) {
    const double before = massProperties(file.bodies[b]).mass;
    const double after = massProperties(found.model.arm.bodies[b]).mass;
    if (!(before > 0.0) || after < kTimes * before) continue;
    warnings.push_back(fmt::format(
        "{} would weigh {:.3g} kg, {:.3g} kg in the robot's file: are efforts in the unit that their columns say, and "
        "the torque constants those of the joints?",
        file.bodies[b].name, after, before));
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

std::vector<std::string> jointNames(const RobotLog& log) {
  std::vector<std::string> names;
  for (const RobotJointLog& joint : log.joints) names.push_back(joint.name);
  return names;
}

/// By what adds to the base parameters' own uncertainty. \param of_model  covariance, shape (K, K)
/// \param of_log  variances of what the log alone says, shape (K)
void widen(DynamicsFit& fit, const MatrixXd& of_model, const VectorXd& of_log, std::size_t blocks) {
  const double quantile = studentQuantile(static_cast<double>(blocks) - 1.0);
  fit.base_covariance += of_model;
  for (std::size_t k = 0; k < fit.base.size(); ++k) {
    Estimate& e = fit.base[k].estimate;
    e.sd = std::sqrt(e.sd * e.sd + of_log[static_cast<Eigen::Index>(k)]);
    e = withInterval(e, quantile * e.sd);
  }
}

/// A bandwidth too low takes from accelerations, one too high leaves noise in them, and what is smoothed away beside a
/// turn leaks into the rows after it: alike in all blocks, so that no jackknife over blocks sees it. What a fit to
/// motion that is smoothed less finds otherwise is taken for its standard uncertainty.
void widenBySmoothing(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options,
                      const RobotRegressor& regressor, const BaseParameters& base, const std::vector<double>& constants,
                      RobotFit& found) {
  const RobotLog sharper = sharperMotion(log);
  const std::vector<bool> all(log.blocks.size(), true);
  const ExtraColumn load = options.payload ? payloadTorques(*options.payload, sharper, regressor, arm) : ExtraColumn();
  const DynamicsSums sums = sumDynamics(sharper, regressor, base, found.model.curves, all, {}, load);
  const DynamicsData data{arm, regressor, base, sums};
  DynamicsFit& fit = found.fit;
  const VectorXd moved = fittedParameters(data, constants, all) - fit.model.parameters;
  const VectorXd of_base = data.base.combination * moved;
  fit.sd = (fit.sd.cwiseAbs2() + moved.cwiseAbs2()).cwiseSqrt();
  VectorXd alone = solveBase(data, data.sums.total(all), constants).x;
  for (Eigen::Index k = 0; k < alone.size(); ++k) alone[k] -= fit.base[static_cast<std::size_t>(k)].estimate.value;
  widen(fit, of_base * of_base.transpose(), alone.cwiseAbs2(), all.size());
}

/// What the friction of joints is beside another curve, by how likely that is.
struct OtherCurves {
  const RobotRegressor& regressor;
  const BaseParameters& base;
  std::vector<double> weights;       ///< shape (N): of all curves together, the best one's 1
  std::vector<MatrixXd> covariance;  ///< shape (N) of (K, K): sums of weight times the square of what moves

  void add(std::size_t joint, double weight, const VectorXd& moved) {
    const Eigen::Index first = regressor.frictionColumn(joint);
    VectorXd own = VectorXd::Zero(moved.size());
    for (Eigen::Index k = 0; k < moved.size(); ++k) {
      const Eigen::Index term = base.columns[static_cast<std::size_t>(k)] - first;
      if (term >= 0 && term < std::ssize(regressor.law().terms)) own[k] = moved[k];
    }
    weights[joint] += weight;
    covariance[joint] += weight * own * own.transpose();
  }
};

/// A curve is the best of a few, and beside another its joint's friction is another: those of the curves next to it
/// count by how likely the rows are with them, exp(-n / 2 ln(variance / least variance)) of n independent rows.
void widenByCurves(const ArmModel& arm, const RobotLog& log, const RobotRegressor& regressor,
                   const BaseParameters& base, const std::vector<double>& constants, RobotFit& found) {
  if (!regressor.law().hasStribeck()) return;
  DynamicsFit& fit = found.fit;
  const std::vector<StribeckCurve>& chosen = found.model.curves;
  const std::vector<double> top = topSpeeds(log);
  const std::vector<bool> some = thinnedBlocks(log, std::vector<bool>(log.blocks.size(), true));
  const auto solveWith = [&](const std::vector<StribeckCurve>& curves) {
    const DynamicsSums sums = sumDynamics(log, regressor, base, curves, some, {}, found.load);
    return solveBase({arm, regressor, base, sums}, sums.total(some), constants);
  };
  const BaseSolution best = solveWith(chosen);
  const Eigen::Index all = best.x.size();
  OtherCurves others{regressor, base, std::vector<double>(chosen.size(), 1.0),
                     std::vector<MatrixXd>(chosen.size(), MatrixXd::Zero(all, all))};
  for (const double step : kSteps) {
    for (const std::vector<StribeckCurve>& curves : besideCurves(chosen, step)) {
      const BaseSolution other = solveWith(curves);
      for (std::size_t c = 0; c < chosen.size(); ++c) {
        if (curves[c].v_s >= kFastest * top[c]) continue;
        const double worse = std::max(0.0, std::log(other.variance[c] / best.variance[c]));
        others.add(c, std::exp(-0.5 * fit.rows[c] / fit.inflation * worse), other.x - best.x);
      }
    }
  }
  MatrixXd spread = MatrixXd::Zero(all, all);
  for (std::size_t c = 0; c < chosen.size(); ++c) spread += others.covariance[c] / others.weights[c];
  for (Eigen::Index k = 0; k < all; ++k) {
    double& sd = fit.sd[base.columns[static_cast<std::size_t>(k)]];
    sd = std::hypot(sd, std::sqrt(spread(k, k)));
  }
  widen(fit, spread, spread.diagonal(), log.blocks.size());
}

std::vector<int> foldsOverSessions(const RobotLog& log) {
  std::vector<int> folds;
  for (const Block& block : log.blocks) folds.push_back(log.session[block.begin]);
  return folds;
}

/// What the model's file says of what was found.
void fillModel(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options,
               const RobotRegressor& regressor, RobotFit& found) {
  RobotModel& model = found.model;
  model.arm = armWith(arm, regressor, found.fit.model.parameters);
  model.law = options.law;
  model.currents = log.joints.front().effort_unit == "A";
  if (model.currents) model.torque_constants = found.fit.model.torque_constants;
  model.parameters = found.fit.model.parameters;
  model.sd = found.fit.sd;
  model.base_covariance = found.fit.base_covariance;
  model.heldout_sd = found.heldout.sd;
  for (const RobotJointLog& joint : log.joints) model.presliding.push_back(joint.presliding);
}

}  // namespace

void requireRobotLog(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options) {
  checkLogOfRobot(log, options);
  checkGravity(arm, log);
}

RobotFit fitRobot(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options) {
  RobotRegressor regressor(arm, friction::find(options.law));
  const BaseParameters base = baseParameters(regressor, arm);
  requireRobotLog(arm, log, options);
  RobotFit found;
  found.names = regressor.names();
  found.units = regressor.units();
  found.without_effect = base.without_effect;
  const std::vector<bool> all(log.blocks.size(), true);
  if (options.payload) found.load = payloadTorques(*options.payload, log, regressor, arm);
  std::vector<double> constants = options.torque_constants.value_or(std::vector<double>(log.joints.size(), 1.0));
  const auto sumsOf = [&](const RobotRegressor& by, const std::vector<StribeckCurve>& curves) {
    return std::make_shared<const DynamicsSums>(sumDynamics(log, by, base, curves, all, {}, found.load));
  };
  std::shared_ptr<const DynamicsSums> sums;
  const auto sumUp = [&] {
    found.model.curves = findCurves(log, regressor, base, constants, all, found.load);
    sums = sumsOf(regressor, found.model.curves);
  };
  MatrixXd of_constants = MatrixXd::Zero(std::ssize(base.columns), std::ssize(base.columns));
  if (log.joints.front().effort_unit == "A" &&
      !options.torque_constants) {  // the load is the file's until torques are known
    sumUp();
    const TorqueConstants told = findTorqueConstants({arm, regressor, base, *sums}, jointNames(log));
    found.constants = told.constants;
    constants = told.values();
    of_constants = told.base_covariance;
  }
  if (regressor.law().needsLoad() || sums == nullptr) {
    findLoad(arm, log, base, constants, all, found.load, regressor);
    sumUp();
  }
  found.fit = fitDynamics({arm, regressor, base, *sums}, constants);
  widen(found.fit, of_constants, of_constants.diagonal(), log.blocks.size());
  widenBySmoothing(arm, log, options, regressor, base, constants, found);
  widenByCurves(arm, log, regressor, base, constants, found);
  if (!found.fit.converged) {
    throw NumericsError(
        "the search for bodies that can exist did not converge: is the log of this robot, with efforts of its signs "
        "and "
        "times in seconds?");
  }
  // Held-out blocks have no part in choosing the curves, or the load, that are to predict them.
  const SumsOfFold sums_of = [&](const std::vector<bool>& fitted) {
    if (!regressor.law().hasStribeck() && !regressor.law().needsLoad()) return sums;
    RobotRegressor own(arm, regressor.law());
    findLoad(arm, log, base, constants, fitted, found.load, own);
    return sumsOf(own, findCurves(log, own, base, constants, fitted, found.load));
  };
  const auto judge = [&](const std::vector<int>& fold) {
    return crossValidate(arm, regressor, base, sums_of, constants, fold);
  };
  found.heldout = judge(foldsOverBlocks(log.blocks.size()));
  if (log.session_names.size() > 1) found.over_logs = judge(foldsOverSessions(log));
  fillModel(arm, log, options, regressor, found);
  found.warnings = warningsOf(arm, log, found);
  return found;
}

}  // namespace simgap
