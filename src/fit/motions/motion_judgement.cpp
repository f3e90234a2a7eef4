// What a calibration on motions found: errors before and after, what is known of the parameters, what to expect.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "motion_prediction.h"
#include "simgap/core/joint_kind.h"
#include "simgap/fit/motions/motion_calibration.h"

namespace simgap {
namespace {

constexpr double kAlike = 0.95;  // correlation of what can hardly be told apart

Verdict verdictOf(double sd, bool has_prior) {
  if (!has_prior) return std::isfinite(sd) ? Verdict::kIdentifiable : Verdict::kNotIdentifiable;
  return verdictOfShare(sd);
}

/// \param sd  of z, shape (size of z)
std::vector<MotionParameter> parametersOf(const MotionPosterior& posterior, const MotionFit& fit,
                                          const Eigen::VectorXd& sd) {
  std::vector<MotionParameter> parameters;
  const ScaledParameters& scaled = posterior.parameters();
  for (Eigen::Index i = 0; i < scaled.size(); ++i) {
    const SearchParameter& p = posterior.space().parameters()[i];
    const double slope = scaled.slope(i, fit.z[i]);
    SearchParameter known = p;
    if (known.prior_sd) known.prior_sd = scaled.slope(i, 0.0);
    parameters.push_back(
        {std::move(known), scaled.value(i, fit.z[i]), slope * sd[i], fit.z[i], verdictOf(sd[i], scaled.hasPrior(i))});
  }
  const Eigen::Index last = scaled.size();
  const double unit = posterior.options().capture_delay_sd;
  const ParameterSpec delay{"capture_delay_s", "s", unit * posterior.lower(last), unit * posterior.upper(last)};
  parameters.push_back({{delay, 0.0, unit, unit},
                        posterior.captureDelay(fit.z),
                        unit * sd[last],
                        fit.z[last],
                        verdictOf(sd[last], true)});
  return parameters;
}

/// Of each parameter the one it is least told apart from, each pair once.
std::vector<std::string> alikePairs(const std::vector<MotionParameter>& parameters, const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd root = covariance.diagonal().cwiseSqrt();
  std::set<std::pair<Eigen::Index, Eigen::Index>> told;
  std::vector<std::string> words;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    Eigen::Index other = -1;
    double strongest = kAlike;
    for (Eigen::Index j = 0; j < covariance.rows(); ++j) {
      const double r = std::abs(covariance(i, j) / (root[i] * root[j]));
      if (i == j || r < strongest) continue;
      strongest = r;
      other = j;
    }
    if (other < 0 || !told.insert(std::minmax(i, other)).second) continue;
    words.push_back(fmt::format("{} and {}: these motions tell little but their {} (correlation {:.3f})",
                                parameters[i].name, parameters[other].name,
                                covariance(i, other) < 0.0 ? "sum" : "difference",
                                covariance(i, other) / (root[i] * root[other])));
  }
  return words;
}

MotionSetResult playSet(const char* name, const MotionSet& set, const MotionCalibrationTask& task, const ArmModel& best,
                        double delay) {
  const PoseLayout layout = task.model.poseLayout();
  const MotionOptions& options = task.config.motions.motion;
  MotionSetResult result{
      name, set, playAll(task.model, set.motions, options), playAll(best, set.motions, options, delay), {}, {}};
  result.initial = motionRms(set.motions, result.before, layout);
  result.final = motionRms(set.motions, result.after, layout);
  return result;
}

/// Joints in units of their noise, as one number; infinite where a motion cannot be played.
double jointError(const MotionRms& rms, const MotionNoise& noise) {
  double sum = 0.0;
  for (std::size_t j = 0; j < rms.joints.size(); ++j) sum += rms.joints[j] / noise.joints[j];
  return std::isfinite(sum) ? sum : kInfinity;
}

std::string failureOf(const MotionSetResult& set, const MotionCalibrationResult& result) {
  const MotionOptions& options = result.config.motions.motion;
  for (std::size_t m = 0; m < set.after.size(); ++m) {
    if (set.after[m].valid || !set.before[m].valid) continue;
    return fmt::format("the result is worse than the start, which model.yaml keeps: {} motion {}: {}", set.name,
                       set.set.motions[m].name, describeFailure(set.after[m], result.layout, options));
  }
  if (!(jointError(set.final, result.noise) > jointError(set.initial, result.noise))) return {};
  std::string change;
  for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
    const JointKind& kind = kindOf(result.layout.joints[j].type);
    change += fmt::format("{}{} from {:.2f} to {:.2f} {}", j ? ", " : "", result.layout.joints[j].name,
                          kind.shown(set.initial.joints[j]), kind.shown(set.final.joints[j]), kind.error_unit);
  }
  return fmt::format(
      "the result is worse than the start, which model.yaml keeps: on the {} motions {}; see whether "
      "motions and model belong together (simgap validate MODEL --motions)",
      set.name, change);
}

void predict(const MotionCalibrationTask& task, const MotionPosterior& posterior, const MotionFit& fit,
             MotionCalibrationResult& result) {
  const MotionSetResult& seen = result.sets[0];
  std::vector<MotionRms> fitted;
  for (std::size_t m = 0; m < seen.after.size(); ++m) {
    fitted.push_back(motionRms({&seen.set.motions[m], 1}, {&seen.after[m], 1}, result.layout));
  }
  const MotionPosterior unseen(task.model, task.validation->motions, {}, task.config.parameters, task.config.pose_noise,
                               task.config.motions);
  const auto prediction = predictMotions(posterior, fit, result.misfit, fitted, unseen);
  if (!prediction) return;
  result.sets[1].predicted = prediction->median;
  result.sets[1].lower = prediction->lower;
  result.sets[1].upper = prediction->upper;
}

}  // namespace

MotionCalibrationResult judgeMotions(const MotionCalibrationTask& task, const MotionCalibration& calibration,
                                     MotionFit fit) {
  const MotionPosterior& posterior = calibration.posterior();
  const ArmModel best = posterior.modelAt(fit.z);
  MotionCalibrationResult result{.layout = task.model.poseLayout(),
                                 .sets = {},
                                 .parameters = {},
                                 .words = {},
                                 .noise = posterior.noise(),
                                 .fit = {},
                                 .state = calibration.state(),
                                 .config = task.config,
                                 .failure = {},
                                 .model = best};
  const double delay = posterior.captureDelay(fit.z);
  result.sets.push_back(playSet("calibration", task.motions, task, best, delay));
  if (task.validation) result.sets.push_back(playSet("validation", *task.validation, task, best, delay));
  const MotionEvaluation at = posterior.evaluate(fit.z);
  result.misfit = std::sqrt(meanSquareOf(posterior, at));
  result.objective_before = posterior.evaluate(Eigen::VectorXd::Zero(posterior.size())).objective;
  const Eigen::VectorXd sd = deviationsOf(posterior, at, fit.jacobians, fit.covariance, fit.step_left);
  result.parameters = parametersOf(posterior, fit, sd);
  result.words = alikePairs(result.parameters, fit.covariance);
  if (result.sets.size() > 1) predict(task, posterior, fit, result);
  for (const MotionSetResult& set : result.sets) {
    if (result.failure.empty()) result.failure = failureOf(set, result);
  }
  if (!result.failure.empty()) result.model = task.model;
  result.fit = std::move(fit);
  return result;
}

}  // namespace simgap
