#include "simgap/optimize/uncertainty.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSingular = 1e-9;  // of the largest singular value of the scaled Jacobian
constexpr double kTakesPart = 0.2;  // component of a direction that cannot be determined
constexpr double kAlias = 0.995;    // correlation from which only a combination is determined

/// Rows of one session that are summed together before the correlation time, and so the length of a block, is known.
constexpr double kPieces = 400.0;

/// Sums over blocks of `pieces_per_block` pieces; none reaches over a session's end.
std::vector<NormalSums> joinPieces(const std::vector<NormalSums>& sums, std::span<const Block> pieces,
                                   std::span<const int> session, std::size_t pieces_per_block) {
  std::vector<NormalSums> blocks;
  std::size_t first = 0;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const bool opens = p == 0 || session[pieces[p].begin] != session[pieces[first].begin];
    if (opens || p - first == pieces_per_block) {
      first = p;
      blocks.push_back(sums[p]);
      continue;
    }
    blocks.back().normal += sums[p].normal;
    blocks.back().score += sums[p].score;
  }
  return blocks;
}

/// (J^T J)^-1 over some columns of R, with the directions that the data do not determine left out.
struct Bread {
  MatrixXd inverse;              ///< shape (F, F)
  std::vector<bool> determined;  ///< shape (F)
};

Bread bread(const MatrixXd& r) {
  const Index n = r.cols();
  if (n == 0) return {MatrixXd(0, 0), {}};
  VectorXd scale = r.colwise().norm();
  for (Index j = 0; j < n; ++j) scale[j] = scale[j] > 0.0 ? 1.0 / scale[j] : 0.0;
  const Eigen::JacobiSVD<MatrixXd> svd(r * scale.asDiagonal(), Eigen::ComputeFullV);
  Bread result{MatrixXd::Zero(n, n), std::vector<bool>(static_cast<std::size_t>(n), true)};
  for (Index k = 0; k < n; ++k) {
    const double s = k < svd.singularValues().size() ? svd.singularValues()[k] : 0.0;
    const VectorXd v = svd.matrixV().col(k);
    if (s > kSingular * svd.singularValues()[0]) {
      const VectorXd direction = scale.cwiseProduct(v) / s;
      result.inverse += direction * direction.transpose();
      continue;
    }
    for (Index j = 0; j < n; ++j) {
      if (std::abs(v[j]) > kTakesPart) result.determined[static_cast<std::size_t>(j)] = false;
    }
  }
  return result;
}

/// Names of undetermined parameters, and of pairs of which only a combination is determined.
std::vector<std::string> describe(const Uncertainty& result) {
  std::vector<std::string> sentences;
  std::string lost;
  for (const Estimate& e : result.estimates) {
    if (!e.identifiable) lost += (lost.empty() ? "" : ", ") + e.name;
  }
  if (!lost.empty()) {
    const bool several = lost.find(',') != std::string::npos;
    sentences.push_back(fmt::format("{} cannot be found from this log{}", lost,
                                    several ? ": only combinations of them act on it" : ""));
  }
  for (std::size_t i = 0; i < result.estimates.size(); ++i) {
    const Estimate& e = result.estimates[i];
    if (e.fixed || !e.identifiable || e.at_bound) continue;
    if (e.sd > std::abs(e.value) && e.value != 0.0) {
      sentences.push_back(
          fmt::format("{} is hardly determined: {:.3g} with a standard deviation of {:.3g}", e.name, e.value, e.sd));
    }
    for (std::size_t k = 0; k < i; ++k) {
      const double correlation = result.correlation(static_cast<Index>(i), static_cast<Index>(k));
      if (std::abs(correlation) < kAlias) continue;
      sentences.push_back(fmt::format("{} and {} are determined together only (correlation {:.4f})",
                                      result.estimates[k].name, e.name, correlation));
    }
  }
  return sentences;
}

}  // namespace

double correlationTime(const Eigen::VectorXd& residual, std::span<const int> session) {
  constexpr double kWindow = 6.0;  // correlation times after which the sum stops
  const Index n = residual.size();
  const double variance = residual.squaredNorm();
  if (!(variance > 0.0)) return 1.0;
  double time = 1.0;
  for (Index lag = 1; lag < n / 4 && static_cast<double>(lag) < kWindow * std::max(time, 1.0); ++lag) {
    double sum = 0.0;
    const bool one_session = session.front() == session.back();
    if (one_session) {
      sum = residual.head(n - lag).dot(residual.tail(n - lag));
    } else {
      for (Index i = 0; i + lag < n; ++i) {
        if (session[static_cast<std::size_t>(i)] == session[static_cast<std::size_t>(i + lag)]) {
          sum += residual[i] * residual[i + lag];
        }
      }
    }
    time += 2.0 * sum / variance;
  }
  return std::max(time, 1.0);
}

double studentQuantile(double degrees_of_freedom) {
  constexpr double z = 1.959963984540054;
  const double v = std::max(degrees_of_freedom, 1.0);
  return z + (std::pow(z, 3) + z) / (4.0 * v) +
         (5.0 * std::pow(z, 5) + 16.0 * std::pow(z, 3) + 3.0 * z) / (96.0 * v * v) +
         (3.0 * std::pow(z, 7) + 19.0 * std::pow(z, 5) + 17.0 * std::pow(z, 3) - 15.0 * z) / (384.0 * v * v * v);
}

Uncertainty estimateUncertainty(const LeastSquaresProblem& problem, std::span<const double> theta,
                                std::span<const int> session) {
  constexpr double kBlockTimes = 12.0;  // length of a block in correlation times
  constexpr std::size_t kFewestBlocks = 40;
  const auto count = static_cast<Index>(theta.size());
  const std::vector<int> free = problem.freeParameters();
  const auto n = static_cast<double>(problem.rows());
  const double rows_per_piece = std::max(1.0, std::ceil(n / kPieces));
  const std::vector<Block> pieces = splitRows(session, static_cast<std::size_t>(rows_per_piece));
  const Linearisation at = linearise(problem, theta, pieces);
  const VectorXd& r = at.residual;
  Uncertainty result;
  result.correlation_rows = correlationTime(r, session);
  result.n_effective = n / result.correlation_rows;

  const double pieces_per_block =
      std::clamp(std::ceil(kBlockTimes * result.correlation_rows / rows_per_piece), 1.0,
                 std::max(1.0, std::floor(n / (static_cast<double>(kFewestBlocks) * rows_per_piece))));
  const std::vector<NormalSums> sums = joinPieces(at.sums, pieces, session, static_cast<std::size_t>(pieces_per_block));
  const bool sandwich = pieces_per_block * rows_per_piece >= 3.0 * result.correlation_rows &&
                        sums.size() >= std::max<std::size_t>(kFewestBlocks / 2, 3 * free.size());
  if (sandwich) result.blocks = sums.size();
  const double variance = r.squaredNorm() / std::max(n - static_cast<double>(free.size()), 1.0);

  // Which columns of the factor are estimated: those on a bound are not free to move.
  std::vector<bool> bound(free.size());
  for (std::size_t j = 0; j < free.size(); ++j) {
    const auto i = static_cast<std::size_t>(free[j]);
    bound[j] = atBound(problem.parameters[i], theta[i]);
  }
  const auto covarianceOf = [&](const std::vector<Index>& chosen, std::vector<bool>& determined) {
    const Bread inner = bread(at.factor(Eigen::all, chosen));
    determined = inner.determined;
    if (!sandwich) return MatrixXd(variance * result.correlation_rows * inner.inverse);
    // What the estimate would move by without the block, to first order: (J^T J - J_b^T J_b)^-1 J_b^T r_b.
    const auto f = static_cast<Index>(chosen.size());
    MatrixXd meat = MatrixXd::Zero(f, f);
    for (const NormalSums& block : sums) {
      const MatrixXd rest = MatrixXd::Identity(f, f) - block.normal(chosen, chosen) * inner.inverse;
      const VectorXd score = block.score(chosen);
      VectorXd move = inner.inverse * rest.partialPivLu().solve(score);
      if (!move.allFinite()) move = inner.inverse * score;  // all that is known of a parameter is in this block
      meat += move * move.transpose();
    }
    const auto b = static_cast<double>(sums.size());
    return MatrixXd(meat * ((b - 1.0) / b));
  };
  std::vector<Index> inside, everything;
  for (std::size_t j = 0; j < free.size(); ++j) {
    everything.push_back(static_cast<Index>(j));
    if (!bound[j]) inside.push_back(static_cast<Index>(j));
  }
  std::vector<bool> determined, determined_all;
  const MatrixXd covariance = covarianceOf(inside, determined);
  const MatrixXd covariance_all = covarianceOf(everything, determined_all);

  result.covariance = MatrixXd::Zero(count, count);
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const FitParameter& p = problem.parameters[i];
    result.estimates.push_back({p.name, p.unit, theta[i], 0.0, theta[i], theta[i], false, p.fixed, true});
  }
  const double degrees = sandwich ? static_cast<double>(sums.size()) - 1.0
                                  : std::max(result.n_effective - static_cast<double>(free.size()), 1.0);
  const double t = studentQuantile(degrees);
  for (std::size_t a = 0; a < inside.size(); ++a) {
    const auto i = static_cast<std::size_t>(free[static_cast<std::size_t>(inside[a])]);
    Estimate& e = result.estimates[i];
    e.identifiable = determined[a];
    e.sd = determined[a] ? std::sqrt(covariance(static_cast<Index>(a), static_cast<Index>(a))) : kNaN;
    e.lower95 = std::max(e.value - t * e.sd, problem.parameters[i].lower);
    e.upper95 = std::min(e.value + t * e.sd, problem.parameters[i].upper);
    if (!determined[a]) e.lower95 = e.upper95 = kNaN;
    for (std::size_t b = 0; b < inside.size(); ++b) {
      if (!determined[a] || !determined[b]) continue;
      const int k = free[static_cast<std::size_t>(inside[b])];
      result.covariance(static_cast<Index>(i), k) = covariance(static_cast<Index>(a), static_cast<Index>(b));
    }
  }
  for (std::size_t j = 0; j < free.size(); ++j) {
    if (!bound[j]) continue;
    const auto i = static_cast<std::size_t>(free[j]);
    Estimate& e = result.estimates[i];
    e.at_bound = true;
    const double sd =
        determined_all[j] ? std::sqrt(covariance_all(static_cast<Index>(j), static_cast<Index>(j))) : kNaN;
    e.sd = kNaN;
    e.identifiable = determined_all[j];
    e.lower95 = std::max(e.value - t * sd, problem.parameters[i].lower);
    e.upper95 = std::min(e.value + t * sd, problem.parameters[i].upper);
    if (!determined_all[j]) e.lower95 = e.upper95 = kNaN;
  }
  const VectorXd deviation = result.covariance.diagonal().cwiseSqrt();
  result.correlation = MatrixXd::Identity(count, count);
  for (Index i = 0; i < count; ++i) {
    for (Index k = 0; k < count; ++k) {
      if (i != k && deviation[i] > 0.0 && deviation[k] > 0.0) {
        result.correlation(i, k) = result.covariance(i, k) / (deviation[i] * deviation[k]);
      }
    }
  }
  result.findings = describe(result);
  return result;
}

}  // namespace simgap
