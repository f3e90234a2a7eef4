#include "left_out_effects.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool follow(const FrictionData& data, std::size_t i) {
  return i + 1 < data.rows() && data.row[i + 1] == data.row[i] + 1 && data.session[i + 1] == data.session[i];
}

/// Central differences where both neighbours are rows of the log that follow each other, else one-sided; 0 for a row
/// that stands alone. \param predicted  from row `first` on; `rows` lie inside.
VectorXd rates(const FrictionData& data, const Eigen::ArrayXd& predicted, std::size_t first, const Block& rows) {
  VectorXd rate = VectorXd::Zero(rows.size());
  for (std::size_t i = rows.begin; i < rows.end; ++i) {
    const std::size_t before = i > 0 && follow(data, i - 1) ? i - 1 : i, after = follow(data, i) ? i + 1 : i;
    if (before == after) continue;
    rate[i - rows.begin] =
        (predicted[after - first] - predicted[before - first]) / (data.time[after] - data.time[before]);
  }
  return rate;
}

/// Of Gauss-Newton's step: the parameters that move, what it is, and the diagonal of the inverse normal matrix.
struct Step {
  std::vector<Index> inside;  ///< places among the free parameters
  VectorXd step, inverse;
};

Step stepOf(const Linearisation& at, std::vector<Index> inside) {
  const VectorXd scale = at.sums[0].normal.diagonal()(inside).cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  MatrixXd normal = scale.asDiagonal() * at.sums[0].normal(inside, inside) * scale.asDiagonal();
  normal.diagonal().array() += 1e-12;  // what has no effect does not move
  const MatrixXd inverse = normal.ldlt().solve(MatrixXd::Identity(normal.rows(), normal.cols()));
  const VectorXd score = at.sums[0].score(inside);
  const VectorXd step = -scale.cwiseProduct(inverse * scale.cwiseProduct(score));
  return {std::move(inside), step, scale.cwiseAbs2().cwiseProduct(inverse.diagonal())};
}

}  // namespace

double rowSeconds(const FrictionData& data) {
  double seconds = 0.0;
  std::size_t steps = 0;
  for (std::size_t i = 0; i + 1 < data.rows(); ++i) {
    if (!follow(data, i)) continue;
    seconds += data.time[i + 1] - data.time[i];
    ++steps;
  }
  return seconds / static_cast<double>(std::max<std::size_t>(steps, 1));
}

Eigen::ArrayXd slopeOfVelocity(const FrictionData& data) {
  constexpr double kHalf = 0.05;  // [s]: of 2 Hz, as fast as a bench moves, a tenth of a second leaves 95 %
  constexpr Index kPairs = 8;     // of rows before and after: more of a fast log tell no more
  const Index n = data.time.size();
  if (!data.timed) return Eigen::ArrayXd::Zero(n);
  const auto most = static_cast<Index>(std::max(kHalf / std::max(rowSeconds(data), 1e-9), 1.0));
  std::vector<Index> after(data.rows(), 0);  // rows that follow
  for (Index i = n - 2; i >= 0; --i) after[i] = follow(data, i) ? after[i + 1] + 1 : 0;
  Eigen::ArrayXd slope = Eigen::ArrayXd::Zero(n);
  for (Index i = 1, before = 0; i < n; ++i) {
    before = follow(data, i - 1) ? before + 1 : 0;
    // As far on both sides, or a start would look like what comes after it.
    const Index half = std::min({most, before, after[i]}), stride = std::max<Index>(half / kPairs, 1);
    double rise = 0.0, run = 0.0;
    for (Index k = stride; k <= half; k += stride) {
      rise += static_cast<double>(k) * (data.velocity[i + k] - data.velocity[i - k]);
      run += static_cast<double>(k) * (data.time[i + k] - data.time[i - k]);
    }
    if (run > 0.0) slope[i] = rise / run;
  }
  return slope;
}

LeastSquaresProblem withLeftOut(const LeastSquaresProblem& problem, const FrictionData& data,
                                const Eigen::ArrayXd& target, const Eigen::ArrayXd& acceleration,
                                const std::vector<double>& theta) {
  constexpr double kMostRows = 3.0;  // a first order is enough for
  const double most = kMostRows * rowSeconds(data);
  const bool in_load = std::ranges::find(data.derived, "acceleration") != data.derived.end();
  LeastSquaresProblem with = problem;
  with.parameters.push_back({kLeftOut[kDelay], "s", -most, most});
  with.parameters.back().fixed = !data.timed;
  with.parameters.push_back({kLeftOut[kInertia], "1", -kInfinity, kInfinity});
  with.parameters.back().fixed = in_load || (acceleration == 0.0).all();
  with.evaluate = [&problem, &data, &target, &acceleration, theta](std::span<const double> at, const Block& rows,
                                                                   Eigen::Ref<VectorXd> residual,
                                                                   Eigen::Ref<MatrixXd>* jacobian) {
    const Index own = theta.size();
    const Block wide{rows.begin - std::min<std::size_t>(rows.begin, 1), std::min(rows.end + 1, data.rows())};
    VectorXd predicted(wide.size());
    problem.evaluate(theta, wide, predicted, nullptr);
    predicted += target.segment(wide.begin, wide.size()).matrix();
    const VectorXd rate = rates(data, predicted, wide.begin, rows);
    const auto faster = acceleration.segment(rows.begin, rows.size()).matrix();
    if (jacobian == nullptr) {
      problem.evaluate(at.first(own), rows, residual, nullptr);
    } else {
      Eigen::Ref<MatrixXd> of_problem = jacobian->leftCols(own);
      problem.evaluate(at.first(own), rows, residual, &of_problem);
      jacobian->col(own + kDelay) = -rate;
      jacobian->col(own + kInertia) = faster;
    }
    residual += at[own + kInertia] * faster - at[own + kDelay] * rate;
  };
  return with;
}

std::optional<LeftOutEffect> leftOutEffect(const LeastSquaresProblem& with_left_out, std::span<const double> theta,
                                           std::span<const int> session) {
  constexpr double kSeen = 2.0;
  const Block whole{0, with_left_out.rows()};
  const Linearisation at = linearise(with_left_out, theta, std::span(&whole, 1));
  const std::vector<int> free = with_left_out.freeParameters();
  const Index own = std::ssize(theta) - std::ssize(kLeftOut);
  std::vector<Index> inside, left_out;  // what stands on a bound stays there
  for (Index j = 0; j < std::ssize(free); ++j) {
    if (free[j] >= own)
      left_out.push_back(j);
    else if (!atBound(with_left_out.parameters[free[j]], theta[free[j]]))
      inside.push_back(j);
  }
  const Step without = stepOf(at, inside);
  const Index k = std::ssize(inside);
  const double variance =
      at.residual.squaredNorm() / static_cast<double>(with_left_out.rows()) * correlationTime(at.residual, session);
  while (!left_out.empty()) {
    std::vector<Index> moving = inside;
    moving.insert(moving.end(), left_out.begin(), left_out.end());
    const Step with = stepOf(at, std::move(moving));
    const Eigen::ArrayXd sd = (variance * with.inverse.array().tail(std::ssize(left_out))).sqrt();
    const Eigen::ArrayXd seen = with.step.array().tail(std::ssize(left_out)).abs() / sd;
    Index least = 0;
    if (!(seen.minCoeff(&least) > kSeen)) {
      left_out.erase(left_out.begin() + least);
      continue;
    }
    LeftOutEffect effect{VectorXd::Zero(own), VectorXd::Ones(own)};
    for (Index i = 0; i < k; ++i) {
      effect.shift[free[inside[i]]] = with.step[i];
      effect.widening[free[inside[i]]] = std::sqrt(with.inverse[i] / without.inverse[i]);
    }
    for (Index i = 0; i < std::ssize(left_out); ++i) {
      effect.value[free[left_out[i]] - own] = with.step[k + i];
      effect.sd[free[left_out[i]] - own] = sd[i];
    }
    return effect;
  }
  return std::nullopt;
}

}  // namespace simgap
