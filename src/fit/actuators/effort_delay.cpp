#include "effort_delay.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Central differences where both neighbours are rows of the log that follow each other, else one-sided; 0 for a row
/// that stands alone. \param predicted  from row `first` on; `rows` lie inside.
VectorXd rates(const FrictionData& data, const Eigen::ArrayXd& predicted, std::size_t first, const Block& rows) {
  const auto follow = [&](std::size_t i) {
    return i + 1 < data.rows() && data.row[i + 1] == data.row[i] + 1 && data.session[i + 1] == data.session[i];
  };
  VectorXd rate = VectorXd::Zero(rows.size());
  for (std::size_t i = rows.begin; i < rows.end; ++i) {
    const std::size_t before = i > 0 && follow(i - 1) ? i - 1 : i, after = follow(i) ? i + 1 : i;
    if (before == after) continue;
    rate[i - rows.begin] =
        (predicted[after - first] - predicted[before - first]) / (data.time[after] - data.time[before]);
  }
  return rate;
}

}  // namespace

double rowSeconds(const FrictionData& data) {
  double seconds = 0.0;
  std::size_t steps = 0;
  for (std::size_t i = 0; i + 1 < data.rows(); ++i) {
    if (data.row[i + 1] != data.row[i] + 1 || data.session[i + 1] != data.session[i]) continue;
    seconds += data.time[i + 1] - data.time[i];
    ++steps;
  }
  return seconds / static_cast<double>(std::max<std::size_t>(steps, 1));
}

LeastSquaresProblem withDelay(const LeastSquaresProblem& problem, const FrictionData& data,
                              const Eigen::ArrayXd& target, const std::vector<double>& theta) {
  constexpr double kMostRows = 3.0;  // a first order is enough for
  const double most = kMostRows * rowSeconds(data);
  LeastSquaresProblem delayed = problem;
  delayed.parameters.push_back({kEffortDelay, "s", -most, most});
  delayed.evaluate = [&problem, &data, &target, theta](std::span<const double> at, const Block& rows,
                                                       Eigen::Ref<VectorXd> residual, Eigen::Ref<MatrixXd>* jacobian) {
    const Index own = theta.size();
    const Block wide{rows.begin - std::min<std::size_t>(rows.begin, 1), std::min(rows.end + 1, data.rows())};
    VectorXd predicted(wide.size());
    problem.evaluate(theta, wide, predicted, nullptr);
    predicted += target.segment(wide.begin, wide.size()).matrix();
    const VectorXd rate = rates(data, predicted, wide.begin, rows);
    if (jacobian == nullptr) {
      problem.evaluate(at.first(own), rows, residual, nullptr);
    } else {
      Eigen::Ref<MatrixXd> of_problem = jacobian->leftCols(own);
      problem.evaluate(at.first(own), rows, residual, &of_problem);
      jacobian->col(own) = -rate;
    }
    residual -= at[own] * rate;
  };
  return delayed;
}

std::optional<DelayEffect> delayEffect(const LeastSquaresProblem& delayed, std::span<const double> theta,
                                       std::span<const int> session) {
  constexpr double kSeen = 2.0;
  const Block whole{0, delayed.rows()};
  const Linearisation at = linearise(delayed, theta, std::span(&whole, 1));
  const std::vector<int> free = delayed.freeParameters();
  std::vector<Index> inside;  // what stands on a bound stays there; the delay is the last
  for (Index j = 0; j < std::ssize(free); ++j) {
    if (!atBound(delayed.parameters[free[j]], theta[free[j]])) inside.push_back(j);
  }
  const Index last = std::ssize(inside) - 1;
  const VectorXd scale = at.sums[0].normal.diagonal()(inside).cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  MatrixXd normal = scale.asDiagonal() * at.sums[0].normal(inside, inside) * scale.asDiagonal();
  normal.diagonal().array() += 1e-12;  // what has no effect does not move
  const MatrixXd with = normal.ldlt().solve(MatrixXd::Identity(last + 1, last + 1));
  const MatrixXd without = normal.topLeftCorner(last, last).ldlt().solve(MatrixXd::Identity(last, last));
  const VectorXd score = at.sums[0].score(inside);
  const VectorXd step = -scale.cwiseProduct(with * scale.cwiseProduct(score));
  const double variance =
      at.residual.squaredNorm() / static_cast<double>(delayed.rows()) * correlationTime(at.residual, session);
  DelayEffect effect{VectorXd::Zero(std::ssize(theta) - 1), VectorXd::Ones(std::ssize(theta) - 1), step[last],
                     scale[last] * std::sqrt(variance * with(last, last))};
  if (!(std::abs(effect.delay) > kSeen * effect.sd)) return std::nullopt;
  for (Index k = 0; k < last; ++k) {
    effect.shift[free[inside[k]]] = step[k];
    effect.widening[free[inside[k]]] = std::sqrt(with(k, k) / without(k, k));
  }
  return effect;
}

}  // namespace simgap
