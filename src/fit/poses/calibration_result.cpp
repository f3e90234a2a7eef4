#include "simgap/fit/poses/calibration_result.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/simulate/replay.h"

namespace simgap {

namespace {

/// Over the joints [rad], as counted.
double meanOf(const std::vector<double>& mje, const PoseLayout& layout) {
  double sum = 0.0;
  for (std::size_t j = 0; j < mje.size(); ++j) sum += kindOf(layout.joints[j].type).counted * mje[j];
  return sum / static_cast<double>(mje.size());
}

std::string judgeName(const CalibrationConfig& config) {
  return config.evaluator != "bullet" && config.verify == "bullet" ? config.verify : config.evaluator;
}

/// "elbow from 20.1 to 35.2 deg"
std::string changeText(const ComparedErrors& errors, const PoseLayout& layout) {
  std::string text;
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const JointKind& kind = kindOf(layout.joints[j].type);
    text += fmt::format("{}{} from {:.2f} to {:.2f} {}", j ? ", " : "", layout.joints[j].name,
                        kind.shown(errors.before[j]), kind.shown(errors.after[j]), kind.error_unit);
  }
  return text;
}

/// Why the result is worse on a set; empty: it is not.
std::string worseOn(const SetResult& set, const PoseLayout& layout) {
  if (set.final.valid < set.initial.valid) {
    return fmt::format("of the {} {} poses {} come to rest, {} did before", set.set.poses.size(), set.name,
                       set.final.valid, set.initial.valid);
  }
  const ComparedErrors errors = compareErrors(set, layout.joints.size());
  if (!(meanOf(errors.after, layout) > meanOf(errors.before, layout))) return {};
  return fmt::format("on {} of {} {} poses the mean error went {}", errors.poses, set.set.poses.size(), set.name,
                     changeText(errors, layout));
}

/// What else could be tried.
std::string nextStep(const CalibrationConfig& config) {
  return config.usesPosterior()
             ? "see whether shafts, joints and model belong together (simgap diagnose MODEL --poses), "
               "or try more --starts"
             : "try --optimizer lm";
}

}  // namespace

ComparedErrors compareErrors(const SetResult& set, std::size_t joints) {
  ComparedErrors errors{0, std::vector<double>(joints, 0.0), std::vector<double>(joints, 0.0)};
  const bool nothing_before = set.initial.valid == 0;
  for (std::size_t p = 0; p < set.set.poses.size(); ++p) {
    const std::vector<double>&before = set.initial.errors[p], &after = set.final.errors[p];
    if (after.empty() || (before.empty() && !nothing_before)) continue;
    ++errors.poses;
    for (std::size_t j = 0; j < joints; ++j) {
      errors.before[j] += nothing_before ? std::numeric_limits<double>::quiet_NaN() : before[j];
      errors.after[j] += after[j];
    }
  }
  const auto count = static_cast<double>(errors.poses);  // 0 / 0: NaN
  for (double& mean : errors.before) mean /= count;
  for (double& mean : errors.after) mean /= count;
  return errors;
}

Delivery judgeDelivery(const CalibrationResult& result) {
  for (const SetResult& set : result.sets) {
    const std::string worse = worseOn(set, result.layout);
    if (worse.empty()) continue;
    // Where every pose came to rest before, time and damping were enough: the parameters lead astray, unless a few only
    // creep on.
    const std::size_t poses = set.set.poses.size(), lost = poses - set.final.valid;
    const bool restless = lost > 0 && (set.initial.valid < poses || 10 * lost <= poses);
    return {false, fmt::format("the result is worse than the start, which model.yaml keeps: {}; {}", worse,
                               restless ? describeInvalid(set.final, set.set, result.layout, judgeName(result.config))
                                        : nextStep(result.config))};
  }
  for (const SetResult& set : result.sets) {
    if (set.final.valid == set.set.poses.size()) continue;
    return {set.final.valid > 0,
            set.name + ": " + describeInvalid(set.final, set.set, result.layout, judgeName(result.config))};
  }
  return {};
}

PoseDifference poseDifference(const SetResult& set, const PoseLayout& layout, std::size_t joint) {
  PoseDifference difference;
  int poses = 0;
  for (std::size_t p = 0; p < set.set.poses.size(); ++p) {
    const PoseOutcome& judged = set.final.outcomes[p];
    const PoseOutcome& searched = set.searched->outcomes[p];
    if (judged.status != PoseStatus::kSteady || searched.status != PoseStatus::kSteady) continue;
    const double distance = jointError(layout.joints[joint].type, judged.joints[joint], searched.joints[joint]);
    difference.mean += distance;
    difference.largest = std::max(difference.largest, distance);
    ++poses;
  }
  difference.mean /= poses;  // NaN when there is none
  return difference;
}

void addUncertainty(const ArmModel& model, const ParameterSpace& space, std::span<const double> values,
                    CalibrationResult& result) {
  constexpr std::size_t kUnseen = 200;
  const PoseSet& recorded = result.sets.front().set;
  PosePosterior posterior(model, recorded.poses, space, result.config.noise);
  const Eigen::VectorXd z = posterior.parameters().scaled(values);
  // Descents minimise under the whitening of their first solution; what others found is measured by its own.
  const Eigen::VectorXd& searched = result.state.journal.whitened_at;
  posterior.whiten(searched.size() > 0 ? searched : z);
  try {
    result.uncertainty = assessUncertainty(posterior, z, space);
  } catch (const NumericsError&) {
    return;  // the model is nowhere at rest; its poses are reported as invalid
  }
  result.from_optimum = result.uncertainty->from_optimum;
  if (!(result.from_optimum <= kAtOptimum)) {
    result.uncertainty.reset();
    return;
  }
  for (std::size_t s = 1; s < result.sets.size(); ++s) {
    result.sets[s].predicted = predictError(posterior, z, *result.uncertainty, result.sets[s].set.poses);
  }
  // A set of as many poses as were recorded: the interval is that of a mean over so many.
  std::vector<Pose> unseen = drawCommands(posterior, z, kUnseen, 1);
  if (unseen.size() > recorded.poses.size()) unseen.resize(recorded.poses.size());
  result.predicted_unseen = predictError(posterior, z, *result.uncertainty, unseen);
}

}  // namespace simgap
