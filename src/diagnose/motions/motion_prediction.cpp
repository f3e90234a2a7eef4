#include "motion_prediction.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "motion_candidates.h"
#include "simgap/core/interrupt.h"
#include "simgap/simulate/simulation.h"

namespace simgap {
namespace {

using Eigen::Index;

constexpr double kPartOfSd = 0.5;  // of a standard deviation: rollouts are not straight further away
/// Of a prior's standard deviation, that any direction is uncertain by: what steps of 2 ms leave. The inertia of
/// rotors, which motions tell to a thousandth, is 0.35 % off on every drawn arm.
constexpr double kLeastKnown = 0.03;
constexpr double kFrameTime = 1.0 / 30;  // [s] of a foreseen capture

/// The square root of a covariance: its columns are directions of one standard deviation each.
Eigen::MatrixXd rootOf(const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
  const Eigen::VectorXd sds = axes.eigenvalues().cwiseMax(kLeastKnown * kLeastKnown).cwiseSqrt();
  return axes.eigenvectors() * sds.asDiagonal();
}

Eigen::VectorXd withinBounds(const MotionPosterior& posterior, Eigen::VectorXd z) {
  for (Index i = 0; i < z.size(); ++i) z[i] = std::clamp(z[i], posterior.lower(i), posterior.upper(i));
  return z;
}

/// The fitted numbers of a candidate, in the scale of a fit.
Eigen::VectorXd placeOf(const MotionPosterior& posterior, const MotionCandidate& candidate) {
  Eigen::VectorXd z(posterior.size());
  z.head(z.size() - 1) = posterior.parameters().scaled(posterior.space().values(candidate.model));
  const double clock = posterior.options().capture_delay_sd;
  z[z.size() - 1] = clock > 0.0 ? candidate.capture_delay / clock : 0.0;
  return z;
}

}  // namespace

PredictedMotions predictMotions(const MotionEvidence& evidence, const MotionCandidate& candidate,
                                const ArmChanges& change, std::span<const RecordedMotion> motions) {
  const MotionProblem problem = motionProblem(evidence.given, evidence.config);
  const std::vector<ArmCause> causes = causesBeyond(evidence.given, candidate.model);
  PredictedMotions predicted;
  predicted.posterior = posteriorWith(problem, causes, motions);
  const MotionPosterior& posterior = *predicted.posterior;
  std::vector<ArmModel> models;
  std::vector<double> delays;
  const auto add = [&](ArmModel model, const ArmChanges& changes, double delay) {
    changes.apply(model);
    models.push_back(std::move(model));
    delays.push_back(delay);
  };
  const Eigen::VectorXd z = placeOf(posterior, candidate);
  add(candidate.model, change, candidate.capture_delay);
  const auto pairs = withinUncertainty(change);
  for (const auto& [forward, back] : pairs) {
    add(candidate.model, forward, candidate.capture_delay);
    add(candidate.model, back, candidate.capture_delay);
  }
  const Eigen::MatrixXd root = rootOf(candidate.covariance);
  for (Index k = 0; k < root.cols(); ++k) {
    const Eigen::VectorXd there = withinBounds(posterior, z + kPartOfSd * root.col(k));
    add(posterior.modelAt(there), change, posterior.captureDelay(there));
  }
  const std::vector<std::vector<Eigen::VectorXd>> played = posterior.residualsOf(models, delays);
  stopIfInterrupted();
  predicted.e = played.front();
  predicted.directions = std::ssize(pairs) + root.cols();
  for (std::size_t m = 0; m < motions.size(); ++m) {
    const Index numbers = predicted.e[m].size();
    RowMajorF moves = RowMajorF::Zero(numbers, predicted.directions);
    Index column = 0;
    std::size_t model = 1;
    for (std::size_t k = 0; k < pairs.size(); ++k, ++column, model += 2) {
      const Eigen::VectorXd &forward = played[model][m], &back = played[model + 1][m];
      if (numbers == 0 || forward.size() != numbers || back.size() != numbers) continue;
      moves.col(column) = (0.5 * (forward - back)).cast<float>();
    }
    for (Index k = 0; k < root.cols(); ++k, ++column, ++model) {
      if (numbers == 0 || played[model][m].size() != numbers) continue;
      moves.col(column) = ((played[model][m] - predicted.e[m]) / kPartOfSd).cast<float>();
    }
    predicted.moves.push_back(std::move(moves));
  }
  return predicted;
}

RecordedMotion playedAsRecorded(const MotionEvidence& evidence, const ArmChanges& change,
                                const MotionCommands& commands, const std::string& name) {
  ArmModel model = evidence.candidates.front().model;
  change.apply(model);
  RecordedMotion motion;
  motion.name = name;
  motion.commands = commands;
  for (double time = commands.times.front(); time <= commands.end(); time += kFrameTime) {
    motion.joint_times.push_back(time);
  }
  const MotionOptions& playing = evidence.config.motions.motion;
  SimulationOptions options;
  options.rollout = playing.rollout;
  const MotionStart start = restUnder(model, commands, commands.times.front(), playing.settle);
  const MotionTrack frames = playAt(model, commands, start, motion.joint_times, options);
  for (std::size_t f = 0; f < motion.joint_times.size(); ++f) {
    const std::span<const JointPosition> joints = frames.jointsAt(f);
    motion.joints.emplace_back(joints.begin(), joints.end());
  }
  const MotionTrack rows = playAt(model, commands, start, commands.times, options);
  for (Index m = 0; m < rows.shafts.rows(); ++m) {
    MuscleRecord& record = motion.muscles.emplace_back();
    record.shafts.assign(rows.shafts.cols(), 0.0);
    record.currents = record.shafts;
    Eigen::VectorXd::Map(record.shafts.data(), rows.shafts.cols()) = rows.shafts.row(m);
    Eigen::VectorXd::Map(record.currents.data(), rows.shafts.cols()) = rows.currents.row(m);
  }
  return motion;
}

}  // namespace simgap
