#include "simgap/optimize/least_squares.h"

#include <ceres/ceres.h>
#include <tbb/parallel_for.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::unique_ptr<ceres::LossFunction> makeLoss(const Loss& loss) {
  switch (loss.kind) {
    case LossKind::kHuber:
      return std::make_unique<ceres::HuberLoss>(loss.scale);
    case LossKind::kCauchy:
      return std::make_unique<ceres::CauchyLoss>(loss.scale);
    case LossKind::kTukey:
      return std::make_unique<ceres::TukeyLoss>(loss.scale);
    case LossKind::kSquares:
      break;
  }
  return nullptr;
}

/// The upper triangle of a QR decomposition, shape (columns, columns).
MatrixXd factor(const Eigen::Ref<const MatrixXd>& matrix) {
  const Index columns = matrix.cols();
  MatrixXd upper = MatrixXd::Zero(columns, columns);
  const Index rank = std::min(matrix.rows(), columns);
  const Eigen::HouseholderQR<MatrixXd> qr(matrix);
  upper.topRows(rank) = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
  return upper;
}

/// All rows as seen by Ceres: cost, and the factor of [J r].
class Reduction {
 public:
  /// \param free  indices of the parameters that move.
  Reduction(const LeastSquaresProblem& problem, std::vector<int> free)
      : problem_(problem), free_(std::move(free)), loss_(makeLoss(problem.loss)) {}

  const std::vector<int>& freeParameters() const { return free_; }

  /// Upper triangular, shape (F + 1, F + 1): of [J_free r] with robust weights. Sets `cost`.
  MatrixXd reduce(std::span<const double> theta, double& cost) const {
    std::vector<double> costs(problem_.chunks.size());
    MatrixXd upper = reduce(theta, [&](std::size_t k, const VectorXd& /*r*/, const MatrixXd& /*rows*/,
                                       double of_chunk) { costs[k] = of_chunk; });
    cost = std::accumulate(costs.begin(), costs.end(), 0.0);
    return upper;
  }

  /// The same; `use(k, r, [J_free r], cost)` sees every chunk k: its residuals, weighted rows and cost. From several
  /// threads.
  template <typename Use>
  MatrixXd reduce(std::span<const double> theta, const Use& use) const {
    const Index columns = free_.size() + 1;
    const Index chunks = problem_.chunks.size();
    MatrixXd stacked(chunks * columns, columns);
    tbb::parallel_for(std::size_t{0}, problem_.chunks.size(), [&](std::size_t k) {
      const Index rows = problem_.chunks[k].size();
      VectorXd r(rows);
      MatrixXd all = MatrixXd::Zero(rows, theta.size());
      Eigen::Ref<MatrixXd> jacobian(all);
      problem_.evaluate(theta, problem_.chunks[k], r, &jacobian);
      MatrixXd augmented(rows, columns);
      for (Index j = 0; j + 1 < columns; ++j) augmented.col(j) = all.col(free_[j]);
      augmented.col(columns - 1) = r;
      const double cost = weigh(r, augmented);
      use(k, r, augmented, cost);
      stacked.middleRows(k * columns, columns) = factor(augmented);
    });
    return factor(stacked);
  }

 private:
  /// The robust cost of residuals; scales the rows of `augmented` by the square roots of their weights.
  double weigh(const VectorXd& r, MatrixXd& augmented) const {
    if (loss_ == nullptr) return r.squaredNorm();
    double cost = 0.0;
    for (Index i = 0; i < r.size(); ++i) {
      double rho[3];
      loss_->Evaluate(r[i] * r[i], rho);
      cost += rho[0];
      augmented.row(i) *= std::sqrt(std::max(rho[1], 0.0));
    }
    return cost;
  }

  const LeastSquaresProblem& problem_;
  std::vector<int> free_;
  std::unique_ptr<ceres::LossFunction> loss_;
};

/// Hands the reduced problem to Ceres: F + 1 residuals of F parameters.
class ReducedCost : public ceres::CostFunction {
 public:
  ReducedCost(const Reduction& reduction, std::span<const double> theta)
      : reduction_(reduction), theta_(theta.begin(), theta.end()) {
    const auto count = static_cast<int>(reduction.freeParameters().size());
    set_num_residuals(count + 1);
    mutable_parameter_block_sizes()->push_back(count);
  }

  bool Evaluate(double const* const* parameters, double* out, double** jacobians) const override {
    if (interruptRequested()) return false;
    const std::vector<int>& free = reduction_.freeParameters();
    std::vector<double> theta = theta_;
    for (std::size_t j = 0; j < free.size(); ++j) theta[free[j]] = parameters[0][j];
    const Index count = free.size();
    Eigen::Map<VectorXd> residual(out, count + 1);
    // Most steps are accepted, and then the derivatives are asked for where the cost was: one pass serves both.
    if (theta != at_) {
      upper_ = reduction_.reduce(theta, cost_);
      at_ = theta;
    }
    if (jacobians == nullptr || jacobians[0] == nullptr) {
      residual.setZero();
      residual[count] = std::sqrt(cost_);
      return std::isfinite(cost_);
    }
    residual.head(count) = upper_.col(count).head(count);
    // What the derivatives do not reach, and what a robust loss adds, so that the cost is exact.
    residual[count] = std::sqrt(std::max(cost_ - residual.head(count).squaredNorm(), 0.0));
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(jacobians[0], count + 1,
                                                                                                count);
    jacobian.topRows(count) = upper_.topLeftCorner(count, count);
    jacobian.row(count).setZero();
    return std::isfinite(cost_) && jacobian.allFinite();
  }

 private:
  const Reduction& reduction_;
  std::vector<double> theta_;
  mutable std::vector<double> at_;  ///< where the last pass was: Ceres evaluates one point after the other
  mutable MatrixXd upper_;          ///< its factor of [J r]
  mutable double cost_ = 0.0;
};

/// One run of Ceres over the parameters `free`.
LeastSquaresResult solveFree(const LeastSquaresProblem& problem, const std::vector<int>& free,
                             const std::vector<double>& start, const LeastSquaresOptions& options, double radius) {
  const Reduction reduction(problem, free);
  if (free.empty()) {
    double cost = 0.0;
    reduction.reduce(start, cost);
    return {start, cost, true, 0, "nothing to fit"};
  }
  ReducedCost cost(reduction, start);
  std::vector<double> values;
  for (const int i : free) values.push_back(start[i]);
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(ownership);
  ceres_problem.AddResidualBlock(&cost, nullptr, values.data());
  for (std::size_t j = 0; j < free.size(); ++j) {
    const ParameterSpec& p = problem.parameters[free[j]];
    if (std::isfinite(p.lower)) ceres_problem.SetParameterLowerBound(values.data(), static_cast<int>(j), p.lower);
    if (std::isfinite(p.upper)) ceres_problem.SetParameterUpperBound(values.data(), static_cast<int>(j), p.upper);
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  if (options.dogleg) solver.trust_region_strategy_type = ceres::DOGLEG;
  solver.dogleg_type = ceres::SUBSPACE_DOGLEG;
  solver.initial_trust_region_radius = radius;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.parameter_tolerance = options.parameter_tolerance;
  solver.gradient_tolerance = 1e-16;
  solver.max_num_line_search_step_size_iterations = 0;  // steps are cut at the bounds; solve() holds what they hit
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);
  stopIfInterrupted();
  LeastSquaresResult result{start, 2.0 * summary.final_cost, summary.termination_type == ceres::CONVERGENCE,
                            static_cast<int>(summary.iterations.size()), summary.message};
  for (std::size_t j = 0; j < free.size(); ++j) result.theta[free[j]] = values[j];
  return result;
}

/// The free parameters that the cost presses against a bound they are on.
std::vector<int> pressed(const LeastSquaresProblem& problem, std::span<const double> theta) {
  constexpr double kPress = 1e-7;  // least cosine between a column and the residual: 1e-14 of the cost to be gained
  std::vector<int> on_bound;
  for (const int i : problem.freeParameters()) {
    const ParameterSpec& p = problem.parameters[i];
    const double value = theta[i];
    if (value <= p.lower || value >= p.upper) on_bound.push_back(i);
  }
  if (on_bound.empty()) return {};
  double cost = 0.0;
  const MatrixXd upper = Reduction(problem, on_bound).reduce(theta, cost);
  const Index n = on_bound.size();
  const VectorXd slope = upper.topLeftCorner(n, n).transpose() * upper.col(n).head(n);
  std::vector<int> held;
  for (Index j = 0; j < n; ++j) {
    const int i = on_bound[j];
    const bool low = theta[i] <= problem.parameters[i].lower;
    const double outward = low ? slope[j] : -slope[j];
    if (outward >= -kPress * upper.col(j).norm() * std::sqrt(cost)) held.push_back(i);
  }
  return held;
}

/// Ceres cuts steps at the bounds and then creeps along them: what is pressed against its bound is held there, as the
/// active-set methods do, until nothing changes (Nocedal & Wright 2006, chapter 16.5).
LeastSquaresResult solve(const LeastSquaresProblem& problem, const std::vector<double>& start,
                         const LeastSquaresOptions& options, double radius) {
  constexpr int kRounds = 10;
  LeastSquaresResult result{start, 0.0, false, 0, ""};
  std::vector<int> held = pressed(problem, start);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<int> free = problem.freeParameters();
    std::erase_if(free, [&](int i) { return std::ranges::find(held, i) != held.end(); });
    const int before = result.iterations;
    result = solveFree(problem, free, result.theta, options, radius);
    result.iterations += before;
    std::vector<int> now = pressed(problem, result.theta);
    if (now == held) break;
    held = std::move(now);
  }
  return result;
}

}  // namespace

std::vector<int> LeastSquaresProblem::freeParameters() const {
  std::vector<int> free;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (!parameters[i].fixed) free.push_back(static_cast<int>(i));
  }
  return free;
}

std::vector<Block> evenChunks(std::size_t rows, std::size_t size) {
  std::vector<Block> chunks;
  for (std::size_t begin = 0; begin < rows; begin += size) chunks.push_back({begin, std::min(rows, begin + size)});
  return chunks;
}

LeastSquaresResult minimise(const LeastSquaresProblem& problem, std::vector<double> start,
                            const LeastSquaresOptions& options) {
  for (std::size_t i = 0; i < start.size(); ++i) {
    const ParameterSpec& p = problem.parameters[i];
    if (!p.fixed) start[i] = std::clamp(start[i], p.lower, p.upper);
  }
  LeastSquaresResult result{start, std::numeric_limits<double>::infinity(), false, 0, ""};
  for (const double radius : options.radii) {
    LeastSquaresResult found = solve(problem, start, options, radius);
    if (found.cost < result.cost) result = std::move(found);
  }
  return result;
}

std::size_t rankMinima(std::vector<LeastSquaresResult>& found, double same) {
  std::ranges::stable_sort(found, {}, &LeastSquaresResult::cost);
  std::size_t minima = found.empty() ? 0 : 1;
  for (std::size_t i = 1; i < found.size(); ++i) {
    if (found[i].cost > same * found[i - 1].cost) ++minima;
  }
  return minima;
}

Eigen::VectorXd residuals(const LeastSquaresProblem& problem, std::span<const double> theta) {
  VectorXd all(problem.rows());
  tbb::parallel_for(std::size_t{0}, problem.chunks.size(), [&](std::size_t k) {
    const Block& chunk = problem.chunks[k];
    problem.evaluate(theta, chunk, all.segment(chunk.begin, chunk.size()), nullptr);
  });
  return all;
}

Linearisation linearise(const LeastSquaresProblem& problem, std::span<const double> theta,
                        std::span<const Block> pieces) {
  const std::vector<int> free = problem.freeParameters();
  const Index count = free.size();
  const NormalSums nothing{MatrixXd::Zero(count, count), VectorXd::Zero(count)};
  Linearisation result{VectorXd(problem.rows()), {}, {pieces.size(), nothing}};
  // A piece may reach over several chunks: each chunk sums its share.
  struct Share {
    std::size_t piece;
    NormalSums sums;
  };
  std::vector<std::vector<Share>> shares(problem.chunks.size());
  const MatrixXd upper =
      Reduction(problem, free)
          .reduce(theta, [&](std::size_t k, const VectorXd& r, const MatrixXd& augmented, double /*cost*/) {
            const Block& chunk = problem.chunks[k];
            result.residual.segment(chunk.begin, r.size()) = r;
            auto piece = std::ranges::upper_bound(pieces, chunk.begin, {}, &Block::end);
            for (; piece != pieces.end() && piece->begin < chunk.end; ++piece) {
              const std::size_t begin = std::max(piece->begin, chunk.begin), end = std::min(piece->end, chunk.end);
              const auto rows = augmented.middleRows(begin - chunk.begin, end - begin);
              const auto j = rows.leftCols(count);
              shares[k].push_back({static_cast<std::size_t>(piece - pieces.begin()),
                                   {j.transpose() * j, j.transpose() * rows.col(count)}});
            }
          });
  for (const std::vector<Share>& chunk : shares) {
    for (const Share& share : chunk) {
      result.sums[share.piece].normal += share.sums.normal;
      result.sums[share.piece].score += share.sums.score;
    }
  }
  result.factor = upper.topLeftCorner(count, count);
  return result;
}

bool atBound(const ParameterSpec& parameter, double value) {
  if (parameter.fixed) return false;
  const double width = parameter.upper - parameter.lower;
  const auto near = [&](double bound) {
    if (!std::isfinite(bound)) return false;
    return std::abs(value - bound) <= 1e-6 * std::min(width, std::max(std::abs(value), std::abs(bound)));
  };
  return near(parameter.lower) || near(parameter.upper);
}

void differentiateNumerically(
    std::span<const ParameterSpec> parameters, std::span<const double> theta, std::span<const double> typical,
    const std::function<void(std::span<const double>, Eigen::Ref<Eigen::VectorXd>)>& residual_at,
    Eigen::Ref<Eigen::MatrixXd> jacobian) {
  // Long steps: a rotor's stops jump from one step of the simulation to the next, and such jumps have to average out.
  constexpr double kStep = 1e-4;
  tbb::parallel_for(std::size_t{0}, parameters.size(), [&](std::size_t j) {
    if (parameters[j].fixed) return;
    const double step = kStep * std::max(std::abs(theta[j]), typical[j]);
    std::vector<double> moved(theta.begin(), theta.end());
    VectorXd up(jacobian.rows()), down(jacobian.rows());
    const double high = moved[j] = std::min(theta[j] + step, parameters[j].upper);
    residual_at(moved, up);
    const double low = moved[j] = std::max(theta[j] - step, parameters[j].lower);
    residual_at(moved, down);
    jacobian.col(j) = (up - down) / (high - low);
  });
}

}  // namespace simgap
