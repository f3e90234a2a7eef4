#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "simgap/optimize/separable.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Non-negative least squares on normal equations (Lawson & Hanson 1974, chapter 23); `sign_free` need not be positive.
/// \param normal  shape (C + 1, C + 1) of [X y].
VectorXd solveNonNegative(const MatrixXd& normal, const std::vector<bool>& sign_free) {
  const Index n = normal.cols() - 1;
  VectorXd scale = normal.diagonal().head(n).cwiseSqrt();
  for (Index j = 0; j < n; ++j) scale[j] = scale[j] > 0.0 ? 1.0 / scale[j] : 0.0;
  const MatrixXd g = scale.asDiagonal() * normal.topLeftCorner(n, n) * scale.asDiagonal();
  const VectorXd b = scale.cwiseProduct(normal.col(n).head(n));
  VectorXd x = VectorXd::Zero(n);
  std::vector<bool> passive = sign_free;
  const auto solvePassive = [&] {
    std::vector<Index> set;
    for (Index j = 0; j < n; ++j) {
      if (passive[static_cast<std::size_t>(j)] && scale[j] > 0.0) set.push_back(j);
    }
    MatrixXd gp = g(set, set);
    gp.diagonal().array() += 1e-13;  // collinear columns: any of the solutions
    VectorXd z = VectorXd::Zero(n);
    const VectorXd right = b(set);
    z(set) = VectorXd(gp.ldlt().solve(right));
    return z;
  };
  x = solvePassive();
  const double tolerance = 1e-12 * std::sqrt(std::max(normal(n, n), 0.0));
  for (Index round = 0; round < 3 * n; ++round) {
    const VectorXd slope = b - g * x;
    Index best = -1;
    for (Index j = 0; j < n; ++j) {
      if (passive[static_cast<std::size_t>(j)] || slope[j] <= tolerance) continue;
      if (best < 0 || slope[j] > slope[best]) best = j;
    }
    if (best < 0) break;
    passive[static_cast<std::size_t>(best)] = true;
    for (Index inner = 0; inner <= n; ++inner) {
      const VectorXd z = solvePassive();
      double step = 1.0;
      Index blocking = -1;
      for (Index j = 0; j < n; ++j) {
        const auto k = static_cast<std::size_t>(j);
        if (!passive[k] || sign_free[k] || z[j] > 0.0) continue;
        const double allowed = x[j] / std::max(x[j] - z[j], 1e-300);
        if (allowed < step || blocking < 0) {
          step = std::min(step, allowed);
          blocking = j;
        }
      }
      x += step * (z - x);
      if (blocking < 0) break;
      x[blocking] = 0.0;
      passive[static_cast<std::size_t>(blocking)] = false;
    }
  }
  return x.cwiseProduct(scale);
}

/// Where each coefficient is measured from: its lower bound, its upper bound, or nowhere when it has neither.
enum class Base { kLower, kUpper, kNone, kFixed };

/// c and the target as linear functions of the non-negative unknowns and 1.
MatrixXd substitution(std::span<const LinearTerm> terms, const std::vector<Base>& base) {
  const auto n = static_cast<Index>(terms.size());
  MatrixXd m = MatrixXd::Zero(n + 1, n + 1);
  m(n, n) = -1.0;
  for (Index j = 0; j < n; ++j) {
    const LinearTerm& term = terms[static_cast<std::size_t>(j)];
    const Base from = base[static_cast<std::size_t>(j)];
    if (from != Base::kFixed) m(j, j) = from == Base::kUpper ? -1.0 : 1.0;
    if (from == Base::kNone) continue;
    const double value = from == Base::kUpper ? term.upper : term.lower;
    if (term.times_gain) {
      m.row(j) += value * m.row(0);
    } else {
      m(j, n) += value;
    }
  }
  return m;
}

double gainBound(const LinearTerm& term, double gain) { return term.times_gain ? gain : 1.0; }

}  // namespace

LinearSolution solveBounded(const Eigen::MatrixXd& gram, std::span<const LinearTerm> terms) {
  const auto n = static_cast<Index>(terms.size());
  std::vector<Base> base;
  std::vector<bool> sign_free;
  for (const LinearTerm& term : terms) {
    base.push_back(term.lower == term.upper    ? Base::kFixed
                   : std::isfinite(term.lower) ? Base::kLower
                   : std::isfinite(term.upper) ? Base::kUpper
                                               : Base::kNone);
    sign_free.push_back(base.back() == Base::kNone);
  }
  LinearSolution solution;
  VectorXd augmented;
  // A term that ends beyond its other bound is measured from there instead; few terms have two bounds that matter.
  for (Index round = 0; round <= 2 * n; ++round) {
    const MatrixXd m = substitution(terms, base);
    const MatrixXd reduced = m.transpose() * gram * m;
    MatrixXd normal = reduced;
    normal.col(n) = -reduced.col(n);
    normal.row(n) = -reduced.row(n);
    normal(n, n) = reduced(n, n);
    VectorXd unknown(n + 1);
    unknown << solveNonNegative(normal, sign_free), 1.0;
    augmented = m * unknown;
    bool again = false;
    for (Index j = 0; j < n && !again; ++j) {
      const auto k = static_cast<std::size_t>(j);
      const double gain = gainBound(terms[k], augmented[0]);
      const double slack = 1e-12 * std::abs(augmented[j]);
      if (base[k] == Base::kLower && augmented[j] > terms[k].upper * gain + slack) {
        base[k] = Base::kUpper;
        again = true;
      } else if (base[k] == Base::kUpper && augmented[j] < terms[k].lower * gain - slack) {
        base[k] = Base::kLower;
        again = true;
      }
    }
    if (!again) break;
  }
  solution.coefficients = augmented.head(n);
  solution.cost = std::max(augmented.dot(gram * augmented), 0.0);
  return solution;
}

}  // namespace simgap
