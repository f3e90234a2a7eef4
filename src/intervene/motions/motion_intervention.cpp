#include "simgap/intervene/motions/motion_intervention.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnose/motions/candidate_motions.h"
#include "diagnose/motions/motion_candidates.h"
#include "diagnose/motions/motion_heldout.h"
#include "intervene/held_causes.h"
#include "played_motion.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastSpread = 0.1;  // of the logarithm of mean squares: fewer motions may agree by chance

/// Mean squares of a candidate's residuals; NaN where it cannot play a motion.
MatrixXd squaresOf(const PredictedMotions& predicted, const std::vector<VectorXd>& residuals) {
  return groupSquares(*predicted.posterior, {true, 0.0, residuals, {}});
}

/// How improbable what is left is, beside what was left of motions before the change.
double chanceOfRest(const MatrixXd& squares, const MotionReference& reference) {
  const Eigen::ArrayXd logs = logSquares(squares);
  if (!logs.isFinite().all()) return 0.0;
  const double sd = std::max(kLeastSpread, reference.sd), count = static_cast<double>(logs.size());
  const double error = sd * std::sqrt(1.0 / count + 1.0 / std::max(1, reference.motions));
  return studentTail((logs.mean() - reference.mean) / error, reference.motions - 1.0);
}

/// How improbable a way is beside that to motions before the change that no fit has seen.
double chanceOf(const Way& way, const MotionReference& reference) {
  if (way.axes == 0.0) return 1.0;
  return fisherTail(way.ratio / reference.way, way.axes, std::max(1.0, reference.motions - 1.0));
}

/// Where two candidates' joints are furthest apart: how far, shown as the joint's kind is, and where.
std::pair<double, std::string> furthestApart(const PredictedMotions& one, const PredictedMotions& other,
                                             const std::vector<RecordedMotion>& motions) {
  double largest = 0.0;
  std::string where = "-";
  const std::vector<Joint>& joints = one.posterior->model().joints;
  for (std::size_t m = 0; m < one.e.size(); ++m) {
    if (one.e[m].size() == 0 || other.e[m].size() == 0) continue;
    for (const ResidualBlock& block : one.posterior->motions()[m].blocks()) {
      if (block.group != ChannelGroup::kJoint) continue;
      const VectorXd apart = (one.e[m] - other.e[m]).segment(block.first, block.size) * block.sd;
      const double shown = kindOf(joints[block.item].type).shown(apart.norm());
      if (!(shown > largest)) continue;
      largest = shown;
      where = fmt::format("{} at {:.1f} s of {}", joints[block.item].name, block.time, motions[m].name);
    }
  }
  return {largest, where};
}

}  // namespace

void MotionEvidence::validate() const {
  for (const MotionCandidate& candidate : candidates) {
    const std::vector<ArmCause> causes = causesBeyond(given, candidate.model);
    const ParameterSpace space(withCauses(given, causes), choicesWith(config.parameters, causes, sizesOf(given)));
    const auto size = static_cast<Index>(space.size()) + 1;  // and the capture's clock
    if (candidate.covariance.rows() == size) continue;
    throw ConfigError(fmt::format("candidate '{}': found a covariance of {} parameters, expected {}", candidate.causes,
                                  candidate.covariance.rows(), size));
  }
}

void MotionEvidence::require(const ArmChanges& change) const {
  const HeldCauses held = heldBy(*this);
  for (const ArmChange& part : change.changes) requireHeld(held, part.cause);
}

std::vector<bool> MotionEvidence::rivals() const { return rivalsOf(heldBy(*this)); }

MotionIntervention judgeChange(const MotionEvidence& evidence, const ArmChanges& change, const MotionSet& after,
                               const InterventionProgress& progress) {
  evidence.require(change);
  const MotionProblem problem = motionProblem(evidence.given, evidence.config);
  MotionIntervention result;
  const std::vector<bool> rival = evidence.rivals();
  std::vector<CandidateAnswer> answers;
  bool played = false;
  for (std::size_t c = 0; c < evidence.candidates.size(); ++c) {
    const MotionCandidate& candidate = evidence.candidates[c];
    progress(static_cast<double>(c) / static_cast<double>(evidence.candidates.size()));
    const PredictedMotions predicted = predictMotions(problem, candidate, change, after.motions);
    const Explained explained = explain(predicted, evidence.reference.variance);
    const MatrixXd left = squaresOf(predicted, explained.left);
    PlayedCandidate& prediction = result.predictions.emplace_back();
    prediction.squares = squaresOf(predicted, predicted.e);
    prediction.rms = std::sqrt(meanSquare(prediction.squares));
    prediction.left = std::sqrt(meanSquare(left));
    prediction.p_left = chanceOfRest(left, evidence.reference);
    prediction.p_way = chanceOf(explained.way, evidence.reference);
    prediction.p = std::min(1.0, 2.0 * std::min(prediction.p_left, prediction.p_way));
    prediction.log_odds = explained.log_likelihood;
    prediction.lost =
        static_cast<std::size_t>(std::ranges::count_if(predicted.e, [](const VectorXd& e) { return e.size() == 0; }));
    played = played || prediction.lost < after.motions.size();
    answers.push_back({candidate.causes, prediction.p, 0.0, rival[c], candidate.log_odds, candidate.role == "refused"});
  }
  if (!played) {
    throw DataError(
        fmt::format("{}: no candidate can play any of {} motions: is this the arm of the diagnosis, with the "
                    "change that was stated?",
                    after.file, after.motions.size()));
  }
  const double named = result.predictions.front().log_odds;
  for (std::size_t c = 0; c < answers.size(); ++c) {
    answers[c].log_odds = result.predictions[c].log_odds -= named;
  }
  Judgement judgement = judgeCandidates(answers, "motions");
  result.verdict = judgement.verdict;
  result.sentence = std::move(judgement.sentence);
  return result;
}

ForeseenChange foreseeChange(const MotionEvidence& evidence, const ArmChanges& change,
                             const std::vector<PlannedMotion>& planned, const InterventionProgress& progress) {
  evidence.require(change);
  std::vector<RecordedMotion> motions;
  for (const PlannedMotion& motion : planned) motions.push_back(playedAsRecorded(evidence, change, motion));
  MotionEvidence known = evidence;  // what would be recorded has the noise of what was
  KnownNoise& noise = known.config.motions.noise;
  noise.shafts = evidence.noise.shafts;
  noise.currents = evidence.noise.currents;
  for (std::size_t j = 0; j < evidence.given.joints.size(); ++j) {
    (kindOf(evidence.given.joints[j].type).slides ? noise.slides : noise.joints) = evidence.noise.joints[j];
  }
  const MotionProblem problem = motionProblem(known.given, known.config);
  std::vector<PredictedMotions> predicted;
  for (std::size_t c = 0; c < known.candidates.size(); ++c) {
    progress(static_cast<double>(c) / static_cast<double>(known.candidates.size()));
    predicted.push_back(predictMotions(problem, known.candidates[c], change, motions));
  }
  const std::size_t n = predicted.size();
  ForeseenChange result;
  result.log_odds.assign(n, std::vector<double>(n, 0.0));
  result.smallest = kInfinity;
  const std::vector<bool> rival = evidence.rivals();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      if (i == j) continue;
      result.log_odds[i][j] = worthOf(predicted[i], predicted[j], evidence.reference.variance);
      const bool asked = (i == 0 && rival[j]) || (j == 0 && rival[i]);
      if (asked) result.smallest = std::min(result.smallest, result.log_odds[i][j]);
    }
    const auto [shift, where] = furthestApart(predicted[i], predicted.front(), motions);
    result.largest_shift.push_back(shift);
    result.where.push_back(where);
  }
  return result;
}

}  // namespace simgap
