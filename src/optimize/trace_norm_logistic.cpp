#include "simgap/optimize/trace_norm_logistic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "simgap/core/decompositions.h"
#include "simgap/core/interrupt.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kGapEvery = 10;  // steps: the gap costs as much as one

/// ln(1 + exp(-z)) without overflow.
double softplusOfMinus(double z) { return z > 0.0 ? std::log1p(std::exp(-z)) : -z + std::log1p(std::exp(z)); }

double sigmoidOf(double z) { return z > 0.0 ? 1.0 / (1.0 + std::exp(-z)) : std::exp(z) / (1.0 + std::exp(z)); }

double summedLoss(const VectorXd& margins, const VectorXd& labels, double bias) {
  double sum = 0.0;
  for (Index i = 0; i < labels.size(); ++i) sum += softplusOfMinus(labels[i] * (margins[i] + bias));
  return sum;
}

/// The bias of least loss, where sum q alpha = 0: Newton's steps, halved between what is known to lie on both sides.
double bestBias(const VectorXd& margins, const VectorXd& labels, double bias) {
  constexpr int kSteps = 100;
  double lower = -kSteps - margins.maxCoeff(), upper = kSteps - margins.minCoeff();
  bias = std::clamp(bias, lower, upper);
  for (int step = 0; step < kSteps; ++step) {
    double slope = 0.0, curvature = 0.0;
    for (Index i = 0; i < labels.size(); ++i) {
      const double alpha = sigmoidOf(-labels[i] * (margins[i] + bias));
      slope -= labels[i] * alpha;
      curvature += alpha * (1.0 - alpha);
    }
    (slope > 0.0 ? upper : lower) = bias;
    const double newton = bias - slope / curvature;
    const double next = newton > lower && newton < upper ? newton : 0.5 * (lower + upper);
    if (std::abs(next - bias) <= 1e-13 * (1.0 + std::abs(bias))) break;
    bias = next;
  }
  return bias;
}

/// alpha_t = sigmoid(-q_t a_t), the derivative of the loss by -q_t a_t.
VectorXd dualPoint(const VectorXd& margins, const VectorXd& labels, double bias) {
  VectorXd alpha(labels.size());
  for (Index i = 0; i < labels.size(); ++i) alpha[i] = sigmoidOf(-labels[i] * (margins[i] + bias));
  return alpha;
}

double spectralNorm(const VectorXd& packed, Index dimension) {
  return symmetricEigenvalues(unpackSymmetric(packed, dimension)).cwiseAbs().maxCoeff();
}

double traceNorm(const VectorXd& packed, Index dimension) {
  return symmetricEigenvalues(unpackSymmetric(packed, dimension)).cwiseAbs().sum();
}

VectorXd packOne(const MatrixXd& matrix) {
  const Index d = matrix.rows();
  VectorXd packed(d * (d + 1) / 2);
  Index k = 0;
  for (Index j = 0; j < d; ++j) {
    packed[k++] = matrix(j, j);
    for (Index i = j + 1; i < d; ++i) packed[k++] = std::numbers::sqrt2 * matrix(i, j);
  }
  return packed;
}

/// argmin |X - W|^2 / 2 + threshold |W|_1: the eigenvalues shrink by the threshold. \param norm  set to |W|_1
VectorXd shrunk(const VectorXd& packed, Index dimension, double threshold, double& norm) {
  const SymmetricEigen eigen = symmetricEigen(unpackSymmetric(packed, dimension));
  MatrixXd matrix = MatrixXd::Zero(dimension, dimension);
  norm = 0.0;
  for (Index k = 0; k < dimension; ++k) {
    const double left = std::abs(eigen.values[k]) - threshold;
    if (left <= 0.0) continue;
    norm += left;
    const auto vector = eigen.vectors.col(k);
    matrix.noalias() += std::copysign(left, eigen.values[k]) * vector * vector.transpose();
  }
  return packOne(matrix);
}

/// Fenchel's dual of the objective at alpha s, s as small as |sum s alpha q C| <= penalty demands; sum alpha q = 0
/// holds where the bias is the best one: -sum alpha ln alpha + (1 - alpha) ln(1 - alpha).
double dualObjective(const VectorXd& alpha, double spectral_norm, double penalty) {
  const double scale = std::min(1.0, penalty / std::max(spectral_norm, std::numeric_limits<double>::min()));
  double entropy = 0.0;
  for (const double a : alpha) {
    const double p = scale * a;
    if (p > 0.0 && p < 1.0) entropy -= p * std::log(p) + (1.0 - p) * std::log1p(-p);
  }
  return entropy;
}

/// A point of the search, and what it costs to know about it.
struct Place {
  VectorXd weights, margins;  // margins: tr(W C_t)
  double bias = 0.0, loss = 0.0, norm = 0.0;
};

class Descent {
 public:
  Descent(const MatrixXd& packed, const VectorXd& labels, Index dimension, double penalty)
      : packed_(packed), labels_(labels), dimension_(dimension), penalty_(penalty) {}

  Place at(VectorXd weights, double norm, double bias) const {
    Place place{std::move(weights), {}, bias, 0.0, norm};
    place.margins = packed_ * place.weights;
    settle(place);
    return place;
  }
  /// a + factor (a - b), whose margins are known.
  Place beyond(const Place& a, const Place& b, double factor) const {
    Place place{a.weights + factor * (a.weights - b.weights), a.margins + factor * (a.margins - b.margins), a.bias};
    settle(place);
    return place;
  }
  VectorXd gradient(const Place& place) const {
    return -(packed_.transpose() * labels_.cwiseProduct(dualPoint(place.margins, labels_, place.bias)));
  }
  /// A proximal step from there that the quadratic bound of curvature `curvature` holds for, which grows until it does.
  Place step(const Place& from, double& curvature) const {
    const VectorXd slope = gradient(from);
    for (;; curvature *= 2.0) {
      double norm = 0.0;
      VectorXd weights = shrunk(from.weights - slope / curvature, dimension_, penalty_ / curvature, norm);
      const VectorXd move = weights - from.weights;
      Place place = at(std::move(weights), norm, from.bias);
      const double bound = from.loss + slope.dot(move) + 0.5 * curvature * move.squaredNorm();
      if (place.loss <= bound + 1e-12 * std::abs(bound)) return place;
    }
  }
  double objective(const Place& place) const { return place.loss + penalty_ * place.norm; }
  double relativeGap(const Place& place) const {
    const double primal = objective(place);
    const double dual = dualObjective(dualPoint(place.margins, labels_, place.bias),
                                      spectralNorm(gradient(place), dimension_), penalty_);
    return (primal - dual) / primal;
  }

 private:
  void settle(Place& place) const {
    place.bias = bestBias(place.margins, labels_, place.bias);
    place.loss = summedLoss(place.margins, labels_, place.bias);
  }

  const MatrixXd& packed_;
  const VectorXd& labels_;
  Index dimension_;
  double penalty_;
};

}  // namespace

MatrixXd packSymmetric(std::span<const MatrixXd> matrices) {
  const Index d = matrices.empty() ? 0 : matrices[0].rows();
  MatrixXd packed(std::ssize(matrices), d * (d + 1) / 2);
  for (Index i = 0; i < packed.rows(); ++i) packed.row(i) = packOne(matrices[i]);
  return packed;
}

MatrixXd unpackSymmetric(const VectorXd& packed, Index dimension) {
  MatrixXd matrix(dimension, dimension);
  Index k = 0;
  for (Index j = 0; j < dimension; ++j) {
    matrix(j, j) = packed[k++];
    for (Index i = j + 1; i < dimension; ++i) matrix(i, j) = matrix(j, i) = packed[k++] / std::numbers::sqrt2;
  }
  return matrix;
}

TraceNormFit fitTraceNormLogistic(const MatrixXd& packed, const VectorXd& labels, Index dimension, double penalty,
                                  const TraceNormOptions& options, const VectorXd& start) {
  const Descent descent(packed, labels, dimension, penalty);
  const VectorXd first = start.size() > 0 ? start : VectorXd::Zero(packed.cols());
  Place now = descent.at(first, traceNorm(first, dimension), 0.0);
  Place before = now;
  double momentum = 1.0;
  // A guess: it grows where it is too small, and shrinks slowly.
  double curvature = 0.25 * packed.colwise().norm().maxCoeff() + std::numeric_limits<double>::min();
  TraceNormFit fit;
  while (true) {
    fit.gap = fit.iterations % kGapEvery == 0 ? descent.relativeGap(now) : fit.gap;
    fit.converged = fit.gap <= options.gap;
    if (fit.converged || fit.iterations >= options.max_iterations) break;
    stopIfInterrupted();
    const double next_momentum = 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * momentum * momentum));
    const Place from = descent.beyond(now, before, (momentum - 1.0) / next_momentum);
    Place next = descent.step(from, curvature);
    // Where momentum points uphill it begins anew.
    const bool uphill = (from.weights - next.weights).dot(next.weights - now.weights) > 0.0;
    momentum = uphill ? 1.0 : next_momentum;
    before = uphill ? next : std::move(now);
    now = std::move(next);
    curvature *= 0.95;
    ++fit.iterations;
  }
  fit.weights = now.weights;
  fit.bias = now.bias;
  fit.objective = descent.objective(now);
  return fit;
}

double largestTraceNormPenalty(const MatrixXd& packed, const VectorXd& labels, Index dimension) {
  const Descent descent(packed, labels, dimension, 0.0);
  return spectralNorm(descent.gradient(descent.at(VectorXd::Zero(packed.cols()), 0.0, 0.0)), dimension);
}

double logisticLoss(const VectorXd& log_odds, const VectorXd& labels) {
  return summedLoss(log_odds, labels, 0.0) / static_cast<double>(labels.size());
}

}  // namespace simgap
