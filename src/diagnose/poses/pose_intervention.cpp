#include "simgap/diagnose/poses/pose_intervention.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "pose_fit.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDecisive = 3.0;     // log odds: 20 to 1
constexpr double kImprobable = 1e-3;  // of a distance, were the candidate right: it is refuted
constexpr double kDoubtful = 1e-2;    // and no longer confirmed
constexpr double kFarOff = 8.0;       // [sd] of a pose that no candidate comes near
constexpr double kOutOfReach = 10.0;  // [sd] per component, of a pose that the candidate cannot take

/// Poses as a candidate predicts them after a change.
struct Predicted {
  std::vector<bool> valid;          ///< shape (poses)
  std::vector<VectorXd> raw;        ///< shape (poses) of (dof): predicted less measured [rad], [m]
  std::vector<MatrixXd> whitening;  ///< shape (poses) of (dof, dof)
  VectorXd e;                       ///< shape (n): whitened, of all poses
  MatrixXd covariance;              ///< S, shape (n, n)
  Index dof = 0;
};

std::vector<PoseCause> causesBeyond(const ArmModel& given, const ArmModel& candidate) {
  std::vector<PoseCause> causes;
  for (std::size_t i = given.extensions.size(); i < candidate.extensions.size(); ++i) {
    const Extension& extension = candidate.extensions[i];
    PoseCause& cause = causes.emplace_back(PoseCause{findArmEffect(extension.effect), extension.target, {}});
    for (std::size_t k = 0; k < extension.parameters.size(); ++k) cause.start[k] = extension.parameters[k].value;
  }
  return causes;
}

PoseProblem problemOf(const PoseEvidence& evidence, const CandidateModel& candidate) {
  return {evidence.given, evidence.parameters, evidence.noise, evidence.threads, candidate.stray_friction};
}

/// The fitted numbers of a model with these causes, in the scale of a fit.
VectorXd solutionOf(PoseFit& fit, const ArmModel& model) {
  return fit.posterior().parameters().scaled(fit.space().values(model));
}

class Predicting {
 public:
  Predicting(const PoseEvidence& evidence, const CandidateModel& candidate)
      : evidence_(evidence),
        candidate_(candidate),
        causes_(causesBeyond(evidence.given, candidate.model)),
        curvature_(posteriorCurvature()) {}

  Predicted after(const ArmChanges& change, std::span<const Pose> poses) const {
    Predicted result = predict(change, poses, true);
    for (const auto& [forward, back] : change.withinUncertainty()) {
      const VectorXd g = 0.5 * (predict(forward, poses, false, &result).e - predict(back, poses, false, &result).e);
      result.covariance += g * g.transpose();
    }
    result.covariance *= 1.0 + std::max(0.0, evidence_.excess);
    return result;
  }

 private:
  Eigen::LLT<MatrixXd> posteriorCurvature() const {
    PoseFit fit(problemOf(evidence_, candidate_), evidence_.poses, causes_);
    const VectorXd z = solutionOf(fit, candidate_.model);
    fit.posterior().whiten(z);
    fit.setSolution(z);
    return Eigen::LLT<MatrixXd>(fit.curvature());
  }

  /// \param like  whose whitening is taken over; nullptr: the prediction's own
  Predicted predict(const ArmChanges& change, std::span<const Pose> poses, bool jacobians,
                    const Predicted* like = nullptr) const {
    PoseProblem changed = problemOf(evidence_, candidate_);
    change.apply(changed.nominal);
    ArmModel model = candidate_.model;
    change.apply(model);
    PoseFit fit(changed, poses, causes_);
    const VectorXd z = solutionOf(fit, model);
    fit.posterior().whiten(z);
    Predicted result;
    result.dof = fit.posterior().degreesOfFreedom();
    const Index n = result.dof * std::ssize(poses);
    result.e = VectorXd::Zero(n);
    MatrixXd left = MatrixXd::Zero(z.size(), jacobians ? n : 0);
    std::vector<Index> gone;  // parameters of causes that the change has undone: they are known to be nothing
    Index parameter = static_cast<Index>(fit.ordinary());
    for (const PoseCause& cause : causes_) {
      for (const ArmEffectParameter& p : cause.effect->parameters) {
        if (p.fitted && change.undoes(cause.label())) gone.push_back(parameter);
        parameter += p.fitted ? 1 : 0;
      }
    }
    const std::vector<PoseResidual>& residuals = fit.posterior().evaluate(z, jacobians);
    for (std::size_t p = 0; p < residuals.size(); ++p) {
      const PoseResidual& residual = residuals[p];
      const MatrixXd own = fit.posterior().whitening(p);
      const Index at = result.dof * static_cast<Index>(p);
      result.valid.push_back(residual.valid);
      result.whitening.push_back(own);
      VectorXd raw = VectorXd::Zero(result.dof);
      if (residual.valid) raw = own.triangularView<Eigen::Lower>().solve(residual.error);
      result.raw.push_back(raw);
      const MatrixXd& whitening = like != nullptr ? like->whitening[p] : own;
      result.e.segment(at, result.dof) =
          residual.valid ? VectorXd(whitening * raw) : VectorXd::Constant(result.dof, kOutOfReach);
      if (jacobians && residual.valid) left.middleCols(at, result.dof) = residual.jacobian.transpose();
    }
    for (const Index i : gone) left.row(i).setZero();
    if (jacobians) {
      curvature_.matrixL().solveInPlace(left);
      result.covariance = MatrixXd::Identity(n, n) + left.transpose() * left;
    }
    return result;
  }

  const PoseEvidence& evidence_;
  const CandidateModel& candidate_;
  std::vector<PoseCause> causes_;
  Eigen::LLT<MatrixXd> curvature_;  ///< N = L L^T
};

/// What several predictions agree is an outlier; shape (poses).
std::vector<bool> comparable(const std::vector<Predicted>& predictions, std::size_t poses) {
  std::vector<bool> near(poses, false);
  for (const Predicted& prediction : predictions) {
    for (std::size_t p = 0; p < poses; ++p) {
      const Index at = prediction.dof * static_cast<Index>(p);
      const MatrixXd own = prediction.covariance.block(at, at, prediction.dof, prediction.dof);
      const VectorXd e = prediction.e.segment(at, prediction.dof);
      if (prediction.valid[p] && e.dot(own.llt().solve(e)) < kFarOff * kFarOff) near[p] = true;
    }
  }
  return near;
}

std::vector<Index> componentsOf(const Predicted& prediction, const std::vector<bool>& poses) {
  std::vector<Index> components;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    for (Index i = 0; i < prediction.dof && poses[p]; ++i) {
      components.push_back(prediction.dof * static_cast<Index>(p) + i);
    }
  }
  return components;
}

/// Log density of the measured poses, up to a constant that all candidates share.
double logLikelihood(const Predicted& prediction, const std::vector<bool>& poses, CandidatePrediction& summary) {
  const std::vector<Index> components = componentsOf(prediction, poses);
  const VectorXd e = prediction.e(components);
  const Eigen::LLT<MatrixXd> factor(prediction.covariance(components, components));
  double density = -factor.matrixLLT().diagonal().array().log().sum();
  for (std::size_t p = 0; p < poses.size(); ++p) {
    if (poses[p]) density += prediction.whitening[p].diagonal().array().log().sum();
  }
  summary.distance = e.dot(factor.solve(e));
  summary.freedom = static_cast<int>(components.size());
  summary.p = chiSquaredTail(summary.distance, summary.freedom);
  return density - 0.5 * summary.distance;
}

std::vector<double> jointErrors(const Predicted& prediction, const ArmModel& model) {
  std::vector<double> errors;
  for (std::size_t p = 0; p < prediction.raw.size(); ++p) {
    Index at = 0;
    for (const Joint& joint : model.joints) {
      const Index dof = joint.degreesOfFreedom();
      const double error = prediction.raw[p].segment(at, dof).norm();
      errors.push_back(prediction.valid[p] ? kindOf(joint.type).shown(error) : std::nan(""));
      at += dof;
    }
  }
  return errors;
}

double rootMeanSquare(const std::vector<double>& errors, const std::vector<bool>& poses, std::size_t joints) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!poses[i / joints] || std::isnan(errors[i])) continue;
    sum += errors[i] * errors[i];
    ++count;
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : std::nan("");
}

/// Which candidates contradict the named one, shape (candidates): one that holds all its causes and more does not,
/// unless nothing was named.
std::vector<bool> rivalsOf(const PoseEvidence& evidence) {
  const std::vector<PoseCause> named = causesBeyond(evidence.given, evidence.candidates[0].model);
  std::vector<bool> rivals = {false};
  for (const CandidateModel& candidate : std::span(evidence.candidates).subspan(1)) {
    const std::vector<PoseCause> held = causesBeyond(evidence.given, candidate.model);
    rivals.push_back(named.empty() || std::ranges::any_of(named, [&](const PoseCause& cause) {
                       return std::ranges::find(held, cause.label(), &PoseCause::label) == held.end();
                     }));
  }
  return rivals;
}

/// Undoing what no model holds changes nothing in any of them.
void requireHeld(const PoseEvidence& evidence, const ArmChanges& changes) {
  std::set<std::string> held;
  for (const CandidateModel& candidate : evidence.candidates) {
    for (const PoseCause& cause : causesBeyond(evidence.given, candidate.model)) held.insert(cause.label());
  }
  for (const ArmChange& change : changes.changes) {
    if (change.cause.empty() || held.contains(change.cause)) continue;
    throw ConfigError(fmt::format("found '{}' to undo, which no model of the diagnosis holds; expected one of {}",
                                  change.cause,
                                  held.empty() ? "none: nothing was found" : fmt::format("{}", fmt::join(held, ", "))));
  }
}

std::vector<Predicted> predictAll(const PoseEvidence& evidence, const ArmChanges& change, std::span<const Pose> poses) {
  requireHeld(evidence, change);
  std::vector<Predicted> predictions(evidence.candidates.size());
  forEach(problemOf(evidence, evidence.candidates.front()), predictions.size(),
          [&](std::size_t c) { predictions[c] = Predicting(evidence, evidence.candidates[c]).after(change, poses); });
  return predictions;
}

/// On the candidate that the diagnosis named, by what the poses after the change say alone.
void decide(const PoseEvidence& evidence, Intervention& result) {
  const CandidatePrediction& named = result.predictions.front();
  const std::string& name = evidence.candidates.front().causes;
  const std::vector<bool> rival = rivalsOf(evidence);
  std::size_t best = 0;
  double runner_up = -std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < result.predictions.size(); ++c) {
    if (result.predictions[c].log_odds > result.predictions[best].log_odds) best = c;
    if (rival[c]) runner_up = std::max(runner_up, result.predictions[c].log_odds);
  }
  const CandidatePrediction& first = result.predictions[best];
  if (first.p < kImprobable) {
    result.sentence = fmt::format(
        "none of {} models predicts these poses: what was changed, or what is wrong, is not "
        "what any of them says",
        result.predictions.size());
  } else if (best > 0 && !rival[best] && first.log_odds > kDecisive) {
    result.sentence = fmt::format("{} predicts these poses better than {} alone (odds {:.3g} to 1)",
                                  evidence.candidates[best].causes, name, std::exp(std::min(first.log_odds, 300.0)));
  } else if (first.log_odds > kDecisive || named.p < kImprobable) {
    result.verdict = InterventionVerdict::kRefuted;
    result.sentence = fmt::format("{} predicts these poses, {} does not (odds {:.3g} to 1)",
                                  evidence.candidates[best].causes, name, std::exp(std::min(first.log_odds, 300.0)));
  } else if (named.p >= kDoubtful && runner_up < -kDecisive) {
    result.verdict = InterventionVerdict::kConfirmed;
    result.sentence = fmt::format(
        "{} predicts these poses with nothing refitted, and no model without it does (odds "
        "{:.3g} to 1)",
        name, std::exp(std::min(-runner_up, 300.0)));
  } else {
    result.verdict = InterventionVerdict::kCannotTell;
    result.sentence = fmt::format(
        "these poses do not tell {} from the other models: after this change all predict "
        "much the same",
        name);
  }
}

}  // namespace

std::string_view toString(InterventionVerdict verdict) {
  switch (verdict) {
    case InterventionVerdict::kConfirmed:
      return "confirmed";
    case InterventionVerdict::kRefuted:
      return "refuted";
    case InterventionVerdict::kCannotTell:
      break;
  }
  return "cannot-tell";
}

Intervention judgeChange(const PoseEvidence& evidence, const ArmChanges& change, const PoseSet& after) {
  const std::vector<Predicted> predictions = predictAll(evidence, change, after.poses);
  const std::vector<bool> near = comparable(predictions, after.poses.size());
  Intervention result;
  for (std::size_t p = 0; p < near.size(); ++p) {
    (near[p] ? result.poses : result.left_out).push_back(after.poses[p].name);
  }
  if (result.poses.empty()) {
    throw DataError(
        fmt::format("{}: no candidate comes near any of {} poses: is this the arm of the diagnosis, with "
                    "the change that was stated?",
                    after.file, after.poses.size()));
  }
  std::vector<double> likelihood;
  for (std::size_t c = 0; c < predictions.size(); ++c) {
    CandidatePrediction& summary = result.predictions.emplace_back();
    summary.log_odds_before = evidence.candidates[c].log_odds;
    summary.without_equilibrium = static_cast<std::size_t>(std::ranges::count(predictions[c].valid, false));
    summary.errors = jointErrors(predictions[c], evidence.given);
    summary.rms = rootMeanSquare(summary.errors, near, evidence.given.joints.size());
    likelihood.push_back(logLikelihood(predictions[c], near, summary));
    summary.log_odds = likelihood[c] - likelihood[0];
  }
  decide(evidence, result);
  return result;
}

ForeseenChange foreseeChange(const PoseEvidence& evidence, const ArmChanges& change) {
  const std::vector<Predicted> predictions = predictAll(evidence, change, evidence.poses);
  const std::size_t n = predictions.size(), joints = evidence.given.joints.size();
  ForeseenChange result;
  result.log_odds.assign(n, std::vector<double>(n, 0.0));
  const std::vector<bool> rival = rivalsOf(evidence);
  result.smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      VectorXd apart = VectorXd::Zero(predictions[j].e.size());
      for (std::size_t p = 0; p < evidence.poses.size(); ++p) {
        if (!predictions[i].valid[p] || !predictions[j].valid[p]) continue;
        apart.segment(predictions[j].dof * static_cast<Index>(p), predictions[j].dof) =
            predictions[j].whitening[p] * (predictions[i].raw[p] - predictions[j].raw[p]);
      }
      result.log_odds[i][j] = 0.5 * apart.dot(predictions[j].covariance.llt().solve(apart));
      const bool asked = (i == 0 && rival[j]) || (j == 0 && rival[i]);
      if (asked) result.smallest = std::min(result.smallest, result.log_odds[i][j]);
    }
  }
  for (std::size_t c = 0; c < n; ++c) {
    double largest = 0.0;
    std::string where = "-";
    Predicted apart = predictions[c];
    for (std::size_t p = 0; p < evidence.poses.size(); ++p) apart.raw[p] -= predictions[0].raw[p];
    const std::vector<double> shifts = jointErrors(apart, evidence.given);
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      if (!(shifts[i] > largest)) continue;
      largest = shifts[i];
      where = fmt::format("{} of pose {}", evidence.given.joints[i % joints].name, evidence.poses[i / joints].name);
    }
    result.largest_shift.push_back(largest);
    result.where.push_back(where);
  }
  return result;
}

}  // namespace simgap
