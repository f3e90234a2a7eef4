#include "simgap/optimize/row_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "simgap/core/interrupt.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Normal {
  MatrixXd h;  ///< J^T J
  VectorXd g;  ///< J^T r
};

double costOf(const VectorXd& residual, std::span<const Block> blocks) {
  double cost = 0.0;
  for (const Block& b : blocks) {
    cost += residual.segment(b.begin, b.size()).squaredNorm();
  }
  return cost;
}

Normal normalOf(const MatrixXd& jacobian, const VectorXd& residual, std::span<const Block> blocks) {
  Normal normal{gramOf(jacobian, blocks), VectorXd::Zero(jacobian.cols())};
  for (const Block& b : blocks) {
    normal.g.noalias() += jacobian.middleRows(b.begin, b.size()).transpose() * residual.segment(b.begin, b.size());
  }
  return normal;
}

/// Parameters that a step may move: not fixed, not without effect, not pressed against a bound.
std::vector<Index> freeOnes(const std::vector<ParameterSpec>& parameters, std::span<const double> theta,
                            const Normal& normal) {
  std::vector<Index> free;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const bool pressed = (theta[i] <= parameters[i].lower && normal.g[i] > 0.0) ||
                         (theta[i] >= parameters[i].upper && normal.g[i] < 0.0);
    if (!parameters[i].fixed && !pressed && normal.h(i, i) > 1e-300) free.push_back(i);
  }
  return free;
}

/// The damped step within the bounds: parameters that would leave them are put on them, one after the other, and the
/// rest is solved again. Shape (P).
VectorXd step(const std::vector<ParameterSpec>& parameters, std::span<const double> theta, const Normal& normal,
              std::vector<Index> free, double damping) {
  VectorXd delta = VectorXd::Zero(normal.g.size());
  while (!free.empty()) {
    MatrixXd h = normal.h(free, free);
    const VectorXd scale = h.diagonal().cwiseSqrt().cwiseInverse();
    h = scale.asDiagonal() * h * scale.asDiagonal();
    h.diagonal().array() += damping + 1e-12;
    for (const Index i : free) delta[i] = 0.0;
    const VectorXd slope = normal.g + normal.h * delta;
    const VectorXd g = slope(free);
    delta(free) = -scale.cwiseProduct(VectorXd(h.ldlt().solve(scale.cwiseProduct(g))));
    Index worst = -1;
    double excess = 0.0;
    for (const Index i : free) {
      const double end = theta[i] + delta[i];
      const double beyond = std::max(parameters[i].lower - end, end - parameters[i].upper) * std::sqrt(normal.h(i, i));
      if (beyond > excess) {
        excess = beyond;
        worst = i;
      }
    }
    if (worst < 0) break;
    delta[worst] = (delta[worst] < 0.0 ? parameters[worst].lower : parameters[worst].upper) - theta[worst];
    std::erase(free, worst);
  }
  return delta;
}

}  // namespace

MatrixXd gramOf(const MatrixXd& jacobian, std::span<const Block> blocks) {
  MatrixXd gram = MatrixXd::Zero(jacobian.cols(), jacobian.cols());
  for (const Block& b : blocks) {
    gram.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.middleRows(b.begin, b.size()).transpose());
  }
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  return gram;
}

RowFit fitRows(const RowModel& model, std::span<const Block> blocks, std::vector<double> start,
               const RowFitOptions& options, const RowEvaluation* at_start) {
  const std::vector<ParameterSpec>& parameters = model.parameters();
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (!parameters[i].fixed) start[i] = std::clamp(start[i], parameters[i].lower, parameters[i].upper);
  }
  RowFit fit{std::move(start), 0.0, 0};
  RowEvaluation own;
  VectorXd trial_residual;
  double damping = 1e-6;
  for (; fit.iterations < options.max_iterations; ++fit.iterations) {
    stopIfInterrupted();
    const bool known = at_start != nullptr && fit.iterations == 0;
    if (!known) model.evaluate(fit.theta, own.residual, &own.jacobian);
    const Eigen::VectorXd& residual = known ? at_start->residual : own.residual;
    const Eigen::MatrixXd& jacobian = known ? at_start->jacobian : own.jacobian;
    fit.cost = costOf(residual, blocks);
    const Normal normal = normalOf(jacobian, residual, blocks);
    const std::vector<Index> free = freeOnes(parameters, fit.theta, normal);
    if (free.empty()) break;
    bool better = false;
    double decrease = 0.0;
    for (; damping < 1e4 && !better; damping = better ? std::max(damping * 0.1, 1e-9) : damping * 10.0) {
      const VectorXd delta = step(parameters, fit.theta, normal, free, damping);
      std::vector<double> trial = fit.theta;
      for (const Index i : free) {
        trial[i] = std::clamp(trial[i] + delta[i], parameters[i].lower, parameters[i].upper);
      }
      model.evaluate(trial, trial_residual, nullptr);
      const double cost = costOf(trial_residual, blocks);
      decrease = fit.cost - cost;
      better = decrease > 0.0;
      if (better) {
        fit.theta = std::move(trial);
        fit.cost = cost;
      }
    }
    if (!better || decrease <= options.tolerance * fit.cost) break;
  }
  return fit;
}

double linearisedCost(const RowModel& model, std::span<const Block> blocks, std::span<const double> start) {
  const auto [theta, residual, jacobian] = RowEvaluation(model, start);
  const Normal normal = normalOf(jacobian, residual, blocks);
  const std::vector<Index> free = freeOnes(model.parameters(), start, normal);
  const double cost = costOf(residual, blocks);
  if (free.empty()) return cost;
  const VectorXd delta = step(model.parameters(), start, normal, free, 1e-9);
  return cost + 2.0 * normal.g.dot(delta) + delta.dot(normal.h * delta);
}

Eigen::MatrixXd blockCovariance(const RowModel& model, std::span<const Block> blocks, const RowEvaluation& at) {
  const auto& [theta, residual, jacobian] = at;
  const Normal normal = normalOf(jacobian, residual, blocks);
  std::vector<Index> free;
  for (const Index i : freeOnes(model.parameters(), theta, normal)) {
    const ParameterSpec& p = model.parameters()[i];
    if (!atBound(p, theta[i])) free.push_back(i);
  }
  const Index n = jacobian.cols();
  MatrixXd covariance = MatrixXd::Zero(n, n);
  if (free.empty()) return covariance;
  const MatrixXd h = normal.h(free, free);
  const VectorXd scale = h.diagonal().cwiseSqrt().cwiseInverse();
  MatrixXd scaled = scale.asDiagonal() * h * scale.asDiagonal();
  scaled.diagonal().array() += 1e-12;
  const Index f = free.size();
  const MatrixXd inverse = scale.asDiagonal() * scaled.ldlt().solve(MatrixXd::Identity(f, f)) * scale.asDiagonal();
  MatrixXd scores = MatrixXd::Zero(f, f);
  for (const Block& b : blocks) {
    const Index begin = b.begin, rows = b.size();
    const VectorXd all = jacobian.middleRows(begin, rows).transpose() * residual.segment(begin, rows);
    const VectorXd g = all(free);
    scores += g * g.transpose();
  }
  const double count = static_cast<double>(blocks.size());
  const double correction = count / std::max(count - static_cast<double>(f), 1.0);
  covariance(free, free) = correction * inverse * scores * inverse;
  return covariance;
}

}  // namespace simgap
