#include "candidate_motions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "motion_candidates.h"
#include "simgap/core/interrupt.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kExplainingSteps = 30;  // towards the best x, at most
constexpr double kExplained = 1e-3;   // [sd] a step that ends them
constexpr double kAxisTold = 0.1;     // of an axis of x, that motions say as much of as was known before
constexpr double kLostMotion = 1e4;   // [nats] of a motion that cannot be played
constexpr double kPartOfSd = 0.5;     // of a standard deviation: rollouts are not straight further away
/// Of a prior's standard deviation, that any direction is uncertain by: what steps of 2 ms leave. The inertia of
/// rotors, which motions tell to a thousandth, is 0.35 % off on every drawn arm.
constexpr double kLeastKnown = 0.03;

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

/// G^T W v of all motions that can be played.
VectorXd projected(const PredictedMotions& predicted, const std::vector<VectorXd>& weights,
                   const std::vector<VectorXd>& of) {
  VectorXd sum = VectorXd::Zero(predicted.directions);
  for (std::size_t m = 0; m < of.size(); ++m) {
    if (of[m].size() == 0) continue;
    sum += (predicted.moves[m].transpose() * weights[m].cwiseProduct(of[m]).cast<float>()).cast<double>();
  }
  return sum;
}

/// G^T W G
MatrixXd curvatureOf(const PredictedMotions& predicted, const std::vector<VectorXd>& weights) {
  MatrixXd sum = MatrixXd::Zero(predicted.directions, predicted.directions);
  for (std::size_t m = 0; m < weights.size(); ++m) {
    if (weights[m].size() == 0) continue;
    const RowMajorF& moves = predicted.moves[m];
    sum += (moves.transpose() * weights[m].cast<float>().asDiagonal() * moves).cast<double>();
  }
  return sum;
}

std::vector<VectorXd> weightsOf(const PredictedMotions& predicted, const std::vector<VectorXd>& residuals) {
  std::vector<VectorXd> weights;
  for (std::size_t m = 0; m < residuals.size(); ++m) {
    weights.push_back(residuals[m].size() == 0 ? VectorXd() : predicted.posterior->weights(m, residuals[m]));
  }
  return weights;
}

Way wayTo(const VectorXd& x, const MatrixXd& told) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(told);
  const VectorXd along = axes.eigenvectors().transpose() * x;
  Way way;
  for (Index k = 0; k < along.size(); ++k) {
    const double a = axes.eigenvalues()[k];
    if (a < kAxisTold) continue;
    way.ratio += along[k] * along[k] * (1.0 + a) / a;
    way.axes += 1.0;
  }
  way.ratio /= std::max(1.0, way.axes);
  return way;
}

}  // namespace

PredictedMotions predictMotions(const MotionProblem& problem, const MotionCandidate& candidate,
                                const ArmChanges& change, std::span<const RecordedMotion> motions) {
  const std::vector<ArmCause> causes = causesBeyond(problem.nominal, candidate.model);
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

Explained explain(const PredictedMotions& predicted, double variance) {
  Explained best;
  VectorXd x = VectorXd::Zero(predicted.directions);
  std::vector<VectorXd>& left = best.left;
  left = predicted.e;
  MatrixXd told;
  for (int step = 0; step < kExplainingSteps; ++step) {
    const std::vector<VectorXd> weights = weightsOf(predicted, left);
    told = curvatureOf(predicted, weights) / variance;
    const MatrixXd normal = told + MatrixXd::Identity(x.size(), x.size());
    const VectorXd to = -normal.llt().solve(projected(predicted, weights, predicted.e) / variance);
    const double moved = (to - x).norm();
    x = to;
    for (std::size_t m = 0; m < left.size(); ++m) {
      if (left[m].size() > 0) left[m] = predicted.e[m] + (predicted.moves[m] * x.cast<float>()).cast<double>();
    }
    if (moved < kExplained) break;
  }
  double loss = 0.0;
  for (std::size_t m = 0; m < left.size(); ++m) {
    if (left[m].size() == 0) {
      loss += kLostMotion;
      continue;
    }
    for (const ResidualBlock& block : predicted.posterior->motions()[m].blocks()) {
      loss += 0.5 * robustLoss(left[m].segment(block.first, block.size).squaredNorm()) / variance;
    }
  }
  const MatrixXd normal = told + MatrixXd::Identity(x.size(), x.size());
  const MatrixXd factor = normal.llt().matrixL();
  best.log_likelihood = -loss - 0.5 * x.squaredNorm() - factor.diagonal().array().log().sum();
  best.way = wayTo(x, told);
  return best;
}

double worthOf(const PredictedMotions& right, const PredictedMotions& wrong, double variance) {
  std::vector<VectorXd> apart, ones;
  double squares = 0.0;
  for (std::size_t m = 0; m < right.e.size(); ++m) {
    const bool both = right.e[m].size() > 0 && wrong.e[m].size() > 0;
    apart.push_back(both ? VectorXd(right.e[m] - wrong.e[m]) : VectorXd());
    ones.push_back(VectorXd::Ones(apart.back().size()));
    squares += apart.back().squaredNorm();
  }
  const VectorXd along = projected(wrong, ones, apart) / variance;
  const MatrixXd normal = curvatureOf(wrong, ones) / variance + MatrixXd::Identity(wrong.directions, wrong.directions);
  return 0.5 * std::max(0.0, squares / variance - along.dot(normal.llt().solve(along)));
}

double wayOf(const MotionProblem& problem, const MotionCandidate& candidate, std::span<const RecordedMotion> motions,
             double variance) {
  return explain(predictMotions(problem, candidate, {}, motions), variance).way.ratio;
}

}  // namespace simgap
