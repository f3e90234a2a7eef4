#include "simgap/diagnose/robots/robot_diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnose/verdict.h"
#include "robot_conclusion.h"
#include "robot_evidence.h"
#include "robot_faults.h"
#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/dynamics/base_fit.h"
#include "simgap/fit/dynamics/robot_fit.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// C^-1; directions that are known better than rounding count as known that well.
MatrixXd precisionOf(const MatrixXd& covariance) {
  constexpr double kFinest = 1e-10;
  const VectorXd scale = covariance.diagonal().unaryExpr([](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 1.0; });
  const SymmetricEigen eigen = symmetricEigen(scale.asDiagonal() * covariance * scale.asDiagonal());
  const double least = kFinest * std::max(eigen.values.maxCoeff(), 1e-300);
  const VectorXd inverted = eigen.values.unaryExpr([&](double v) { return 1.0 / std::max(v, least); });
  return scale.asDiagonal() * eigen.vectors * inverted.asDiagonal() * eigen.vectors.transpose() * scale.asDiagonal();
}

/// Every fourth block (of a quarter) only measures; stretches of the others go to folds in turn.
void splitBlocks(const RobotLog& log, double holdout, RobotGround& ground) {
  const auto every = static_cast<std::size_t>(std::max(2.0, std::round(1.0 / std::max(holdout, 0.02))));
  std::size_t training = 0;
  for (std::size_t b = 0; b < log.blocks.size(); ++b) {
    ground.training.push_back(b % every != every / 2);
    ground.fold.push_back(ground.training.back() ? static_cast<int>(training++ % kRobotFolds) : -1);
  }
  if (training >= 2 * kRobotFolds && training < log.blocks.size()) return;
  throw DataError(
      fmt::format("{}: found {} blocks to learn from and {} to hold out, expected at least {} and 1: record "
                  "longer, or hold out less",
                  log.file, training, log.blocks.size() - training, 2 * kRobotFolds));
}

std::vector<RobotHypothesis> hypothesesOf(const RobotRows& rows, const RobotDiagnosisOptions& options) {
  std::vector<RobotHypothesis> all;
  for (const RobotCause* cause : robot_causes::all()) {
    const auto wanted = [&](std::string_view name) { return options.wants(name); };
    if (std::ranges::none_of(cause->names(), wanted)) continue;
    for (RobotHypothesis& h : cause->hypotheses(rows)) {
      if (options.wants(h.cause)) all.push_back(std::move(h));
    }
  }
  return all;
}

std::vector<bool> rowsOf(const RobotLog& log, const std::vector<bool>& blocks) {
  std::vector<bool> rows(log.rows(), false);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (std::size_t i = log.blocks[b].begin; i < log.blocks[b].end; ++i) rows[i] = blocks[b];
  }
  return rows;
}

Cause causeOf(const RobotSearch& search, const RobotSelection& selection, std::size_t k, const RobotSearch::Fit& fit,
              const MatrixXd& covariance, const Interval& gain) {
  const RobotHypothesis& h = search.hypothesis(selection.set[k]);
  Cause cause;
  cause.effect = h.cause;
  cause.form = h.form;
  cause.target = h.target;
  cause.sentence = h.sentence;
  cause.gain_heldout = gain;
  cause.p_adjusted = selection.p_adjusted[k];
  cause.ambiguous_with = selection.ambiguous_with[k];
  Index first = 0;
  for (std::size_t j = 0; j < k; ++j) first += fit.theta[j].size();
  const Index count = fit.theta[k].size();
  MatrixXd slopes = MatrixXd::Identity(count, count);
  const VectorXd shown = h.shown ? h.shown(fit.theta[k], slopes) : fit.theta[k];
  MatrixXd own = slopes * covariance.block(first, first, count, count) * slopes.transpose();
  // Between which two moments a reversal lies no number of rows tells (JCGM 100:2008, F.2.2.1).
  const double step = search.rows().drive(0).step;
  if (h.isDelay()) own(0, 0) += step * step / 12.0;
  const auto blocks = static_cast<double>(std::ranges::count(search.ground().training, true));
  for (Index i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const RobotCauseParameter& parameter = h.shown_as.empty() ? h.parameters[at] : h.shown_as[at];
    const double half = studentQuantile(blocks - 1.0) * std::sqrt(std::max(0.0, own(i, i)));
    if (half == 0.0) continue;  // no joint feels it
    const double value = shown[i] + parameter.neutral;
    cause.parameters.push_back(withInterval({parameter.name, parameter.unit, value}, half));
  }
  return cause;
}

/// By what the ordinary parameters move when the causes are there, in deviations of what was known.
std::vector<Absorption> absorbedBy(const RobotSearch& search, const RobotSearch::Fit& before,
                                   const RobotSearch::Fit& after, const RobotModel& robot) {
  std::vector<Absorption> shifts;
  const std::vector<std::string>& names = search.ground().base.names;
  if (robot.base_covariance.size() == 0) return shifts;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto i = static_cast<Index>(k);
    const double sd = std::sqrt(robot.base_covariance(i, i));
    // Where a cause changes the parameter itself its own part is no shift.
    if (sd > 0.0) shifts.push_back({names[k], (after.z[i] - before.z[i]) / sd});
  }
  return absorbed(std::move(shifts));
}

class RobotDiagnoser {
 public:
  RobotDiagnoser(const RobotModel& robot, RobotLog log, const RobotDiagnosisOptions& options,
                 const DiagnosisProgress& progress)
      : robot_(robot),
        log_(std::move(log)),
        options_(options),
        progress_(progress),
        known_(robot.base_covariance.size() > 0),
        regressor_(robot.arm, friction::find(robot.law)),
        base_(baseParameters(regressor_, robot.arm)),
        ground_{base_, {}, {}, {}, 1.0, {}, {}, {}} {}

  RobotDiagnosis run() {
    RobotFitOptions fit;
    fit.law = robot_.law;
    if (robot_.currents) fit.torque_constants = robot_.torque_constants;
    requireRobotLog(robot_.arm, log_, fit);
    Diagnosis& d = result_.diagnosis;
    d.error_unit = "sd2";
    d.warnings = log_.warnings;
    d.faults = findRobotFaults(regressor_, known_ ? robot_.parameters : VectorXd(), robot_.curves, log_);
    if (const DataFault* fault = openFault(d.faults); fault != nullptr && !options_.ignore_faults) {
      endWith(*fault, d);
      return std::move(result_);
    }
    splitBlocks(log_, options_.holdout, ground_);
    tell("summing the log", 0.0);
    prepare();
    search();
    return std::move(result_);
  }

 private:
  void tell(const char* what, double done) const {
    if (progress_) progress_(what, done);
  }

  /// What the search stands on: weights, what was known, and the flat fit of this log.
  void prepare() {
    ground_.constants.assign(log_.joints.size(), 1.0);
    if (robot_.currents) ground_.constants = robot_.torque_constants;
    const DynamicsSums sums = sumDynamics(log_, regressor_, base_, robot_.curves, ground_.training);
    const DynamicsData data{robot_.arm, regressor_, base_, sums};
    const std::vector<JointSums> training = sums.total(ground_.training);
    if (known_) requireLogOfRobot(data, training, robot_.parameters, ground_.constants, log_.file);
    const BaseSolution flat = solveBase(data, training, ground_.constants);
    ground_.variance = flat.variance;
    ground_.inflation =
        inflationOf(data, training, flat, jackknifeCovariance(data, flat, ground_.constants, ground_.training));
    flat_ = keptParameters(regressor_, base_, flat.x);
    ground_.x0 = known_ ? VectorXd(base_.combination * robot_.parameters) : flat.x;
    if (known_) {
      ground_.precision = precisionOf(robot_.base_covariance);
      return;
    }
    constexpr double kNothing = 1e-9;  // of what the log says
    std::vector<double> variance = ground_.variance;
    for (double& v : variance) v *= ground_.inflation;
    const RobotNormal normal = normalOf(training, base_.acts, std::ssize(base_.columns), variance, ground_.constants);
    ground_.precision = MatrixXd((kNothing * normal.a.diagonal().array().max(1e-12)).matrix().asDiagonal());
  }

  /// Friction of a delayed joint meets the motion of another moment. Where that one was a turn the sign of friction is
  /// as unknown as beside the turn itself: 35 ms came out as 30 with these rows. Beside every turn of that joint they
  /// stay out, too: a joint that sticks while it turns passes for a late effort. \return whether there are any
  bool leaveOutTurnsOfDelays(const RobotSearch& search, const RobotSelection& selection) {
    const RobotRows& rows = search.rows();
    const RobotSearch::Fit fit = search.fit(selection.set, kRobotFolds);
    bool any = false;
    for (std::size_t k = 0; k < selection.set.size(); ++k) {
      const RobotHypothesis& h = search.hypothesis(selection.set[k]);
      for (std::size_t c = 0; h.later && c < rows.joints(); ++c) {
        if (rows.jointName(c) != h.target) continue;
        std::vector<bool>& moves = log_.joints[c].moves;
        const Eigen::ArrayXd& direction = rows.drive(c).direction;
        Eigen::ArrayXd moved(std::ssize(moves));
        for (Index i = 0; i < moved.size(); ++i) moved[i] = moves[static_cast<std::size_t>(i)];
        moved = rows.shifted(moved, h.later(fit.theta[k]));
        const double beside = log_.joints[c].blurred();
        for (const double later : {beside, -beside}) {
          moved = (rows.shifted(direction, later) == direction).select(moved, 0.0);
        }
        for (std::size_t i = 0; i < moves.size(); ++i) {
          any = any || (moves[i] && moved[static_cast<Index>(i)] < 1.0);
          moves[i] = moves[i] && moved[static_cast<Index>(i)] == 1.0;
        }
      }
    }
    return any;
  }

  void search(bool again = false) {
    const RobotRows rows(log_, robot_, regressor_, known_ ? robot_.parameters : flat_, flat_,
                         rowsOf(log_, ground_.training));
    tell("making hypotheses", 0.05);
    RobotSearch search(rows, ground_, hypothesesOf(rows, options_));
    constexpr int kRounds = 5;
    for (int round = 0; round < kRounds; ++round) {
      tell("following those that bend", 0.2 + 0.04 * round);
      if (!search.relinearise()) break;
    }
    RobotSelector selector(search, options_);
    RobotSelection selection = selector.run(progress_);
    if (!again && leaveOutTurnsOfDelays(search, selection)) {
      prepare();
      return this->search(/*again=*/true);
    }
    tell("judging findings", 0.8);
    RobotFindings findings = judgeFindings(search, selector, options_, selection);
    tell("looking at what is left", 0.9);
    report(search, selection, std::move(findings));
  }

  void report(const RobotSearch& search, const RobotSelection& selection, RobotFindings findings) {
    Diagnosis& d = result_.diagnosis;
    const RobotSearch::Fit before = search.fit({}, kRobotFolds), after = search.fit(selection.set, kRobotFolds);
    const MatrixXd covariance = search.covariance(selection.set, after);
    for (std::size_t k = 0; k < selection.set.size(); ++k) {
      d.causes.push_back(causeOf(search, selection, k, after, covariance, findings.gain[k]));
    }
    if (!d.causes.empty()) d.causes.back().absorbed_by = absorbedBy(search, before, after, robot_);
    const MatrixXd torque_before = predictedTorque(search, {}, before),
                   torque_after = predictedTorque(search, selection.set, after);
    measure(search, selection, before, after, d);
    const std::vector<double> floors = noiseFloors(search, torque_after);
    d.noise_floor = floors.back();
    d.candidates = std::move(findings.candidates);
    d.hypotheses = selection.records;
    const RobotUnseen unseen = unseenOf(search, selection.set);
    const RobotLeft left = whatIsLeft(unseen, named_);
    d.left_over_percent = 100.0 * left.share;
    d.unexplained = left.channels;
    d.explainable_percent = std::min(100.0, d.explained_percent + d.left_over_percent);
    d.evidence = robotEvidence(search, selection.set, after, torque_before, torque_after);
    addUntestable(search, known_, d);
    addDetectable(search, selection, options_, d);
    joints(search, after, floors, torque_before, torque_after);
    lookElsewhere(unseen);
    concludeRobot(search, selection, result_);
    warnOfHarm(d);
    if (known_) extend(search, selection, after, covariance);
  }

  /// Errors of all joints, and what the causes explain of those on which they act.
  void measure(const RobotSearch& search, const RobotSelection& selection, const RobotSearch::Fit& before,
               const RobotSearch::Fit& after, Diagnosis& d) {
    std::vector<std::size_t> all(search.rows().joints());
    std::iota(all.begin(), all.end(), std::size_t{0});
    named_.clear();
    for (const std::size_t h : selection.set) {
      for (const std::size_t c : search.joints(h)) {
        if (std::ranges::find(named_, c) == named_.end()) named_.push_back(c);
      }
    }
    if (named_.empty()) named_ = all;
    const std::vector<bool> heldout = ground_.heldout(), every(heldout.size(), true);
    const BlockErrors of_before = search.errors(before.z, every), of_after = search.errors(after.z, every);
    const auto mean = [&](const BlockErrors& errors, const std::vector<bool>& blocks,
                          const std::vector<std::size_t>& joints) {
      return groupErrors(errors, search.counted(), blocks, joints).mse();
    };
    d.samples = log_.rows();
    // Of one joint, as the rows above and the gains of most causes are.
    d.effective_samples = search.counted().sum() / (ground_.inflation * static_cast<double>(search.counted().cols()));
    d.baseline = {mean(of_before, ground_.training, named_), mean(of_before, heldout, named_)};
    d.extended = {mean(of_after, ground_.training, named_), mean(of_after, heldout, named_)};
    d.explained_percent = 100.0 * std::max(0.0, 1.0 - d.extended.mse_heldout / d.baseline.mse_heldout);
  }

  /// What is left in the joints on which no cause acts, each of its own error.
  void lookElsewhere(const RobotUnseen& unseen) {
    const RobotRows& rows = unseen.search.rows();
    for (std::size_t c = 0; c < rows.joints(); ++c) {
      if (std::ranges::find(named_, c) != named_.end()) continue;
      RobotLeft left = whatIsLeft(unseen, {c});
      if (!left.channels.empty()) {
        result_.elsewhere.push_back({rows.jointName(c), left.share, std::move(left.channels)});
      }
    }
  }

  void joints(const RobotSearch& search, const RobotSearch::Fit& fit, const std::vector<double>& floors,
              const MatrixXd& before, const MatrixXd& after) {
    const RobotRows& rows = search.rows();
    result_.before = before;
    result_.after = after;
    for (std::size_t c = 0; c < rows.joints(); ++c) {
      result_.before.col(c) /= ground_.constants[c];
      result_.after.col(c) /= ground_.constants[c];
    }
    RobotLog unseen = log_;  // of whose rows only the held-out ones count
    const std::vector<bool> training = rowsOf(log_, ground_.training);
    for (std::size_t i = 0; i < unseen.rows(); ++i) unseen.usable[i] = unseen.usable[i] && !training[i];
    const std::vector<bool> heldout = ground_.heldout();
    const BlockErrors errors = search.errors(fit.z, heldout);
    const MatrixXd given = known_ ? predictEfforts(robot_, log_) : MatrixXd();
    for (std::size_t c = 0; c < rows.joints(); ++c) {
      const double error = groupErrors(errors, search.counted(), heldout, {c}).mse();
      result_.joints.push_back({rows.jointName(c), log_.joints[c].effort_unit,
                                known_ ? relativeError(unseen, c, given) : std::nan(""),
                                relativeError(unseen, c, result_.before), relativeError(unseen, c, result_.after),
                                error / knownError(search, floors[c], c)});
    }
  }

  void extend(const RobotSearch& search, const RobotSelection& selection, const RobotSearch::Fit& fit,
              const MatrixXd& covariance) {
    RobotModel extended = robot_;
    bool any = selection.set.empty();
    Index first = 0;
    for (std::size_t k = 0; k < selection.set.size(); ++k) {
      const RobotHypothesis& h = search.hypothesis(selection.set[k]);
      const Index count = fit.theta[k].size();
      const bool held =
          holdCause(regressor_, base_, h, fit.theta[k], covariance.block(first, first, count, count), extended);
      first += count;
      any = any || held;
      if (!held) result_.not_held.push_back(h.label());
    }
    if (any) result_.extended = std::move(extended);
  }

  const RobotModel& robot_;
  RobotLog log_;
  const RobotDiagnosisOptions& options_;
  const DiagnosisProgress& progress_;
  bool known_;
  RobotRegressor regressor_;
  BaseParameters base_;
  RobotGround ground_;
  VectorXd flat_;
  std::vector<std::size_t> named_;  ///< joints on which the causes act; all without
  RobotDiagnosis result_;
};

}  // namespace

void RobotDiagnosisOptions::validate() const {
  std::vector<std::string> known;
  for (const RobotCause* cause : robot_causes::all()) {
    for (const std::string_view name : cause->names()) known.emplace_back(name);
  }
  std::ranges::sort(known);
  for (const std::string& effect : effects) {
    if (std::ranges::find(known, effect) != known.end()) continue;
    throw ConfigError(
        fmt::format("--effects: found '{}', expected causes of a robot: {}", effect, fmt::join(known, ", ")));
  }
}

RobotDiagnosis diagnoseRobot(const RobotModel& robot, RobotLog log, const RobotDiagnosisOptions& options,
                             const DiagnosisProgress& progress) {
  options.validate();
  return RobotDiagnoser(robot, std::move(log), options, progress).run();
}

}  // namespace simgap
