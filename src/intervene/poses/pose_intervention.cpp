#include "simgap/intervene/poses/pose_intervention.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "intervene/held_causes.h"
#include "pose_weighing.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFarOff = 8.0;  // [sd] of a pose that no candidate comes near

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

/// The candidate's answer by the poses that some candidate comes near.
double logLikelihood(const PoseEvidence& evidence, std::size_t c, const ArmChanges& change, const Predicted& prediction,
                     std::span<const Pose> after, const std::vector<bool>& near, CandidatePrediction& summary) {
  std::vector<Pose> poses;
  std::vector<Index> components;
  for (std::size_t p = 0; p < near.size(); ++p) {
    if (!near[p]) continue;
    poses.push_back(after[p]);
    for (Index i = 0; i < prediction.dof; ++i) components.push_back(prediction.dof * static_cast<Index>(p) + i);
  }
  const Weighed weighed =
      weighAfter(evidence, evidence.candidates[c], change, poses, prediction.uncertain(components, Eigen::all));
  summary.distance = weighed.distance;
  summary.freedom = static_cast<int>(components.size());
  summary.p = fisherTail(summary.distance / summary.freedom, summary.freedom, prediction.known);
  return weighed.log_likelihood;
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

std::vector<Predicted> predictAll(const PoseEvidence& evidence, const ArmChanges& change, std::span<const Pose> poses) {
  const HeldCauses held = heldBy(evidence);
  for (const ArmChange& part : change.changes) requireHeld(held, part.cause);
  std::vector<Predicted> predictions(evidence.candidates.size());
  forEach(problemOf(evidence, evidence.candidates.front()), predictions.size(), [&](std::size_t c) {
    predictions[c] = PosePrediction(evidence, evidence.candidates[c]).after(change, poses);
  });
  return predictions;
}

/// On the candidate that the diagnosis named, by what the poses after the change say alone.
void decide(const PoseEvidence& evidence, Intervention& result) {
  const std::vector<bool> rival = rivalsOf(heldBy(evidence));
  std::vector<CandidateAnswer> answers;
  for (std::size_t c = 0; c < result.predictions.size(); ++c) {
    answers.push_back({evidence.candidates[c].causes, result.predictions[c].p, result.predictions[c].log_odds, rival[c],
                       result.predictions[c].log_odds_before, evidence.candidates[c].role == "refused"});
  }
  Judgement judgement = judgeCandidates(answers, "poses");
  result.verdict = judgement.verdict;
  result.sentence = std::move(judgement.sentence);
}

}  // namespace

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
  for (std::size_t c = 0; c < predictions.size(); ++c) {
    CandidatePrediction& summary = result.predictions.emplace_back();
    summary.log_odds_before = evidence.candidates[c].log_odds;
    summary.without_equilibrium = static_cast<std::size_t>(std::ranges::count(predictions[c].valid, false));
    summary.errors = jointErrors(predictions[c], evidence.given);
    summary.rms = rootMeanSquare(summary.errors, near, evidence.given.joints.size());
  }
  std::vector<double> likelihood(predictions.size());
  forEach(problemOf(evidence, evidence.candidates.front()), predictions.size(), [&](std::size_t c) {
    likelihood[c] = logLikelihood(evidence, c, change, predictions[c], after.poses, near, result.predictions[c]);
  });
  for (std::size_t c = 0; c < predictions.size(); ++c) result.predictions[c].log_odds = likelihood[c] - likelihood[0];
  decide(evidence, result);
  return result;
}

ForeseenChange foreseeChange(const PoseEvidence& evidence, const ArmChanges& change) {
  const std::vector<Predicted> predictions = predictAll(evidence, change, evidence.poses);
  const std::size_t n = predictions.size(), joints = evidence.given.joints.size();
  ForeseenChange result;
  result.log_odds.assign(n, std::vector<double>(n, 0.0));
  const std::vector<bool> rival = rivalsOf(heldBy(evidence));
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
