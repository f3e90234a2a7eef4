#include "simgap/optimize/uncertainty.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "simgap/core/decompositions.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSingular = 1e-9;      // of the largest singular value of the scaled Jacobian
constexpr double kTakesPart = 0.2;      // component of a direction that cannot be determined
constexpr double kAlias = 0.995;        // correlation from which only a combination is determined
constexpr std::size_t kFewRows = 2000;  // a table, not a log

/// Rows that are summed together before the correlation time, and so the length of a block, is known.
double rowsPerPiece(std::size_t rows) {
  constexpr double kPieces = 400.0;
  return std::max(1.0, std::ceil(static_cast<double>(rows) / kPieces));
}

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

/// The blocks of the jackknife, as long as some correlation times of the residuals, or shorter where that would leave
/// too few; none when they would be shorter than three correlation times, or fewer than three for each parameter.
std::vector<NormalSums> jackknifeBlocks(const std::vector<NormalSums>& sums, std::span<const Block> pieces,
                                        std::span<const int> session, double correlation_rows, std::size_t parameters) {
  constexpr double kBlockTimes = 12.0;  // length of a block in correlation times
  constexpr std::size_t kFewestBlocks = 40;
  const auto rows = static_cast<double>(session.size());
  const double rows_per_piece = rowsPerPiece(session.size());
  const double pieces_per_block =
      std::clamp(std::ceil(kBlockTimes * correlation_rows / rows_per_piece), 1.0,
                 std::max(1.0, std::floor(rows / (static_cast<double>(kFewestBlocks) * rows_per_piece))));
  std::vector<NormalSums> blocks = joinPieces(sums, pieces, session, static_cast<std::size_t>(pieces_per_block));
  const bool long_enough = pieces_per_block * rows_per_piece >= 3.0 * correlation_rows;
  const bool enough = blocks.size() >= std::max<std::size_t>(kFewestBlocks / 2, 3 * parameters);
  if (!long_enough || !enough) blocks.clear();
  return blocks;
}

/// A symmetric matrix over some free parameters, and which of them the data determine.
struct Determined {
  MatrixXd matrix;            ///< shape (F, F)
  std::vector<bool> columns;  ///< shape (F)
};

/// (J^T J)^-1 over some columns of R, with the directions that the data do not determine left out.
Determined inverseNormal(const MatrixXd& r) {
  const Index n = r.cols();
  if (n == 0) return {MatrixXd(0, 0), {}};
  // R D = U S V^T with D the columns' lengths inverted, so (J^T J)^-1 = (R^T R)^-1 = D V S^-2 V^T D.
  VectorXd scale = r.colwise().norm();
  for (Index j = 0; j < n; ++j) scale[j] = scale[j] > 0.0 ? 1.0 / scale[j] : 0.0;
  const RightSingular svd = rightSingular(r * scale.asDiagonal());
  Determined result{MatrixXd::Zero(n, n), std::vector<bool>(n, true)};
  for (Index k = 0; k < n; ++k) {
    const double s = k < svd.values.size() ? svd.values[k] : 0.0;
    const VectorXd v = svd.vectors.col(k);
    if (s > kSingular * svd.values[0]) {
      const VectorXd direction = scale.cwiseProduct(v) / s;
      result.matrix += direction * direction.transpose();
      continue;
    }
    // Nothing in the data opposes a step along this direction: what takes part in it is not determined.
    for (Index j = 0; j < n; ++j) {
      if (std::abs(v[j]) > kTakesPart) result.columns[j] = false;
    }
  }
  return result;
}

/// Covariance of some free parameters while the others stay. \param variance  of an independent residual; used without
/// blocks.
Determined covarianceOf(const std::vector<Index>& chosen, const MatrixXd& factor, const std::vector<NormalSums>& blocks,
                        double variance) {
  Determined result = inverseNormal(factor(Eigen::all, chosen));
  const MatrixXd& inverse = result.matrix;
  // Without blocks: sigma^2 (J^T J)^-1, the variance being that of as many residuals as are independent.
  if (blocks.empty()) {
    result.matrix = MatrixXd(variance * inverse);
    return result;
  }
  // What the estimate would move by without block b, to first order: d_b = (J^T J - J_b^T J_b)^-1 J_b^T r_b, where
  // the inverse is (J^T J)^-1 (1 - J_b^T J_b (J^T J)^-1)^-1.
  const Index f = chosen.size();
  MatrixXd sum = MatrixXd::Zero(f, f);
  for (const NormalSums& block : blocks) {
    const MatrixXd rest = MatrixXd::Identity(f, f) - block.normal(chosen, chosen) * inverse;
    const VectorXd score = block.score(chosen);
    VectorXd move = inverse * rest.partialPivLu().solve(score);
    if (!move.allFinite()) move = inverse * score;  // all that is known of a parameter is in this block
    sum += move * move.transpose();
  }
  // The jackknife: (B - 1) / B sum_b d_b d_b^T.
  const auto b = static_cast<double>(blocks.size());
  result.matrix = MatrixXd(sum * ((b - 1.0) / b));
  return result;
}

/// Deviation and interval value -+ t sd within the bounds; NaN when the data do not determine it.
void setInterval(Estimate& e, const ParameterSpec& spec, double sd, double t) {
  e.identifiable = std::isfinite(sd);
  e.sd = sd;
  e.lower95 = e.identifiable ? std::max(e.value - t * sd, spec.lower) : kNaN;
  e.upper95 = e.identifiable ? std::min(e.value + t * sd, spec.upper) : kNaN;
}

double deviation(const Determined& covariance, std::size_t k) {
  const Index i = k;
  return covariance.columns[k] ? std::sqrt(covariance.matrix(i, i)) : kNaN;
}

/// Where a neighbour that stands on its bound may as well stand within, an estimate would follow it to that side:
/// d theta_i = Cov_ib / Cov_bb d theta_b, for d theta_b up to the end of the neighbour's own interval.
/// \param all  covariance of all free parameters, in the order of `free`
void followBounded(const LeastSquaresProblem& problem, std::span<const int> free, const Determined& all,
                   Uncertainty& result) {
  const Index count = std::ssize(free);
  for (Index i = 0; i < count; ++i) {
    Estimate& e = result.estimates[free[i]];
    if (e.at_bound || !e.identifiable || !all.columns[i]) continue;
    double below = std::pow(e.value - e.lower95, 2), above = std::pow(e.upper95 - e.value, 2);
    for (Index b = 0; b < count; ++b) {
      const Estimate& bounded = result.estimates[free[b]];
      if (!bounded.at_bound || !bounded.identifiable || !(all.matrix(b, b) > 0.0)) continue;
      const bool upwards = bounded.upper95 - bounded.value > bounded.value - bounded.lower95;
      const double reach = (upwards ? bounded.upper95 : bounded.lower95) - bounded.value;
      const double follows = all.matrix(i, b) / all.matrix(b, b) * reach;
      (follows < 0.0 ? below : above) += follows * follows;
    }
    const ParameterSpec& spec = problem.parameters[free[i]];
    e.lower95 = std::max(e.value - std::sqrt(below), spec.lower);
    e.upper95 = std::min(e.value + std::sqrt(above), spec.upper);
  }
}

MatrixXd correlationOf(const MatrixXd& covariance) {
  const Index count = covariance.rows();
  const VectorXd sd = covariance.diagonal().cwiseSqrt();
  MatrixXd correlation = MatrixXd::Identity(count, count);
  for (Index i = 0; i < count; ++i) {
    for (Index k = 0; k < count; ++k) {
      if (i != k && sd[i] > 0.0 && sd[k] > 0.0) correlation(i, k) = covariance(i, k) / (sd[i] * sd[k]);
    }
  }
  return correlation;
}

/// sum_i r_i r_(i + lag) within sessions.
double productsAt(Index lag, const VectorXd& residual, std::span<const int> session) {
  const Index n = residual.size();
  if (session.front() == session.back()) return residual.head(n - lag).dot(residual.tail(n - lag));
  double sum = 0.0;
  for (Index i = 0; i + lag < n; ++i) {
    if (session[i] == session[i + lag]) sum += residual[i] * residual[i + lag];
  }
  return sum;
}

/// Of few rows: the sum over the lags before the first at which residuals are opposed (Geyer 1992). A short log whose
/// errors bend to and fro has as much of them below zero as above, which takes nothing off their being alike.
double correlationTimeOfFew(const VectorXd& residual, std::span<const int> session) {
  const double variance = residual.squaredNorm();
  double time = 1.0;
  for (Index lag = 1; lag < residual.size() / 2; ++lag) {
    const double sum = productsAt(lag, residual, session);
    if (!(sum > 0.0)) break;
    time += 2.0 * sum / variance;
  }
  return time;
}

}  // namespace

std::vector<std::string> describeUndetermined(const Uncertainty& result) {
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
      const double correlation = result.correlation(i, k);
      if (std::abs(correlation) < kAlias) continue;
      sentences.push_back(fmt::format("{} and {} are determined together only (correlation {:.4f})",
                                      result.estimates[k].name, e.name, correlation));
    }
  }
  return sentences;
}

double correlationTime(const Eigen::VectorXd& residual, std::span<const int> session) {
  constexpr double kWindow = 6.0;  // correlation times after which the sum stops
  const double variance = residual.squaredNorm();
  if (!(variance > 0.0)) return 1.0;
  double time = 1.0;
  for (Index lag = 1; lag < residual.size() / 4 && static_cast<double>(lag) < kWindow * std::max(time, 1.0); ++lag) {
    time += 2.0 * productsAt(lag, residual, session) / variance;
  }
  return std::max(time, 1.0);
}

Uncertainty estimateUncertainty(const LeastSquaresProblem& problem, std::span<const double> theta,
                                std::span<const int> session) {
  const Index count = theta.size();
  const std::vector<int> free = problem.freeParameters();
  Uncertainty result;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const ParameterSpec& p = problem.parameters[i];
    result.estimates.push_back(
        withInterval({.name = p.name, .unit = p.unit, .value = theta[i], .fixed = p.fixed}, 0.0));
  }

  // One pass over the rows: the residuals r, the factor of J^T J, and J^T J and J^T r over pieces of the log.
  const auto n = static_cast<double>(problem.rows());
  const std::vector<Block> pieces = splitRows(session, static_cast<std::size_t>(rowsPerPiece(problem.rows())));
  const Linearisation at = linearise(problem, theta, pieces);

  // Residuals that are alike over tau rows tell as much as n / tau independent ones.
  result.correlation_rows = correlationTime(at.residual, session);
  const std::vector<NormalSums> blocks =
      jackknifeBlocks(at.sums, pieces, session, result.correlation_rows, free.size());
  if (blocks.empty() && problem.rows() <= kFewRows) {
    result.correlation_rows = std::max(result.correlation_rows, correlationTimeOfFew(at.residual, session));
  }
  result.n_effective = n / result.correlation_rows;
  result.blocks = blocks.size();
  const auto parameters = static_cast<double>(free.size());
  const double variance = at.residual.squaredNorm() / std::max(n - parameters, 1.0) * result.correlation_rows;
  const double t = studentQuantile(blocks.empty() ? std::max(result.n_effective - parameters, 1.0)
                                                  : static_cast<double>(blocks.size()) - 1.0);
  result.quantile = t;

  // A parameter inside its bounds varies while those on a bound stay there.
  std::vector<Index> inside, everything;
  for (Index j = 0; j < std::ssize(free); ++j) {
    everything.push_back(j);
    const int i = free[j];
    result.estimates[i].at_bound = atBound(problem.parameters[i], theta[i]);
    if (!result.estimates[i].at_bound) inside.push_back(j);
  }
  const Determined covariance = covarianceOf(inside, at.factor, blocks, variance);
  result.covariance = MatrixXd::Zero(count, count);
  for (std::size_t a = 0; a < inside.size(); ++a) {
    const int i = free[inside[a]];
    setInterval(result.estimates[i], problem.parameters[i], deviation(covariance, a), t);
    for (std::size_t b = 0; b < inside.size(); ++b) {
      if (covariance.columns[a] && covariance.columns[b])
        result.covariance(i, free[inside[b]]) = covariance.matrix(a, b);
    }
  }
  // One on a bound has no deviation, but an interval to one side: of the fit in which it may move as well.
  const Determined all = covarianceOf(everything, at.factor, blocks, variance);
  for (std::size_t j = 0; j < free.size(); ++j) {
    Estimate& e = result.estimates[free[j]];
    if (!e.at_bound) continue;
    setInterval(e, problem.parameters[free[j]], deviation(all, j), t);
    e.sd = kNaN;
  }
  followBounded(problem, free, all, result);
  result.correlation = correlationOf(result.covariance);
  result.findings = describeUndetermined(result);
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const Estimate& e = result.estimates[i];
    const ParameterSpec& spec = problem.parameters[i];
    if (!e.at_bound || !(e.lower95 <= spec.lower && e.upper95 >= spec.upper)) continue;
    result.findings.push_back(
        fmt::format("{} may be anything within its bounds, {:.3g} to {:.3g}", e.name, spec.lower, spec.upper));
  }
  return result;
}

void addHeldUncertainty(const LeastSquaresProblem& problem, std::span<const double> theta, std::span<const int> held,
                        const Eigen::MatrixXd& covariance, Uncertainty& result) {
  LeastSquaresProblem all = problem;
  for (const int i : held) all.parameters[i].fixed = false;
  const std::vector<int> columns = all.freeParameters();
  const Block whole{0, problem.rows()};
  const MatrixXd factor = linearise(all, theta, std::span(&whole, 1)).factor;
  std::vector<Index> own, given;  // columns of what was fitted, and of what was held
  for (Index j = 0; j < std::ssize(columns); ++j) {
    const bool is_held = std::ranges::find(held, columns[j]) != held.end();
    if (is_held) given.push_back(j);
    if (!is_held && result.estimates[columns[j]].identifiable) own.push_back(j);
  }
  const Determined inverse = inverseNormal(factor(Eigen::all, own));
  const MatrixXd slopes =
      -inverse.matrix * (factor(Eigen::all, own).transpose() * factor(Eigen::all, given));  // (own, held)
  const MatrixXd added = slopes * covariance * slopes.transpose();
  for (std::size_t a = 0; a < own.size(); ++a) {
    const int i = columns[own[a]];
    Estimate& e = result.estimates[i];
    const auto reach = [&](double bound) {
      return std::hypot(bound - e.value, result.quantile * std::sqrt(added(a, a)));
    };
    e.lower95 = std::max(e.value - reach(e.lower95), problem.parameters[i].lower);
    e.upper95 = std::min(e.value + reach(e.upper95), problem.parameters[i].upper);
    if (e.at_bound) continue;
    e.sd = std::hypot(e.sd, std::sqrt(added(a, a)));
    for (std::size_t b = 0; b < own.size(); ++b) {
      if (!result.estimates[columns[own[b]]].at_bound) result.covariance(i, columns[own[b]]) += added(a, b);
    }
  }
  result.correlation = correlationOf(result.covariance);
}

void knowByInverse(double quantile, const ParameterSpec& spec, Estimate& k) {
  if (k.fixed || k.at_bound || !k.identifiable) return;
  const double inverse = 1.0 / k.value, half = quantile * k.sd;  // ends may lie farther off, but for bounds
  const double above = std::max(half, k.upper95 - k.value) * inverse * inverse,
               below = std::max(half, k.value - k.lower95) * inverse * inverse;
  k.lower95 = std::max(1.0 / (inverse + below), spec.lower);
  k.upper95 = inverse > above ? std::min(1.0 / (inverse - above), spec.upper) : spec.upper;
}

Uncertainty partOf(const Uncertainty& all, std::size_t begin, std::size_t end) {
  Uncertainty part = all;
  part.estimates = {all.estimates.begin() + std::ptrdiff_t(begin), all.estimates.begin() + std::ptrdiff_t(end)};
  const auto rows = Eigen::seq(begin, end - 1);
  part.covariance = all.covariance(rows, rows);
  part.correlation = all.correlation(rows, rows);
  return part;
}

}  // namespace simgap
