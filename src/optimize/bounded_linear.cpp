/// min |y - X c|^2 within bounds, from the normal matrix [X y]^T [X y] alone. A change of variables makes it the
/// non-negative least squares of Lawson & Hanson (1974): c_j = l_j + x_j or u_j - x_j with x_j >= 0, and with a gain
/// (c_j = theta_j c_0) c_j = l_j c_0 + x_j. A term with two bounds is measured from the one at which it ends.
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
  // min x^T G x / 2 - b^T x with unit diagonal of G: columns of any unit weigh the same.
  const Index n = normal.cols() - 1;
  VectorXd scale = normal.diagonal().head(n).cwiseSqrt();
  for (Index j = 0; j < n; ++j) scale[j] = scale[j] > 0.0 ? 1.0 / scale[j] : 0.0;
  const MatrixXd g = scale.asDiagonal() * normal.topLeftCorner(n, n) * scale.asDiagonal();
  const VectorXd b = scale.cwiseProduct(normal.col(n).head(n));
  VectorXd x = VectorXd::Zero(n);
  std::vector<bool> passive = sign_free;
  // z: the minimum over the passive unknowns, while the active ones stay at 0. G_PP z_P = b_P.
  const auto solvePassive = [&] {
    std::vector<Index> set;
    for (Index j = 0; j < n; ++j) {
      if (passive[j] && scale[j] > 0.0) set.push_back(j);
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
    // Kuhn & Tucker: at the minimum no active unknown has a slope inwards. The steepest becomes passive.
    const VectorXd slope = b - g * x;
    Index best = -1;
    for (Index j = 0; j < n; ++j) {
      if (passive[j] || slope[j] <= tolerance) continue;
      if (best < 0 || slope[j] > slope[best]) best = j;
    }
    if (best < 0) break;
    passive[best] = true;
    for (Index inner = 0; inner <= n; ++inner) {
      // Towards z as far as all stay non-negative: step = min x_j / (x_j - z_j) over those with z_j <= 0; the one that
      // blocks becomes active.
      const VectorXd z = solvePassive();
      double step = 1.0;
      Index blocking = -1;
      for (Index j = 0; j < n; ++j) {
        if (!passive[j] || sign_free[j] || z[j] > 0.0) continue;
        const double allowed = x[j] / std::max(x[j] - z[j], 1e-300);
        if (allowed < step || blocking < 0) {
          step = std::min(step, allowed);
          blocking = j;
        }
      }
      x += step * (z - x);
      if (blocking < 0) break;
      x[blocking] = 0.0;
      passive[blocking] = false;
    }
  }
  return x.cwiseProduct(scale);
}

/// Where each coefficient is measured from: its lower bound, its upper bound, or nowhere when it has neither.
enum class Base { kLower, kUpper, kNone, kFixed };

/// M of (c, -1) = M (x, 1): c and the target as linear functions of the non-negative unknowns and 1.
MatrixXd substitution(std::span<const LinearTerm> terms, const std::vector<Base>& base) {
  const Index n = terms.size();
  MatrixXd m = MatrixXd::Zero(n + 1, n + 1);
  m(n, n) = -1.0;
  for (Index j = 0; j < n; ++j) {
    const LinearTerm& term = terms[j];
    const Base from = base[j];
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
  const Index n = terms.size();
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
    // |X c - y|^2 = (c, -1)^T G (c, -1) = (x, 1)^T M^T G M (x, 1): the normal matrix of [X' -y'] in x, with the sign of
    // its last column as solveNonNegative has it.
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
      const double gain = gainBound(terms[j], augmented[0]);
      const double slack = 1e-12 * std::abs(augmented[j]);
      if (base[j] == Base::kLower && augmented[j] > terms[j].upper * gain + slack) {
        base[j] = Base::kUpper;
        again = true;
      } else if (base[j] == Base::kUpper && augmented[j] < terms[j].lower * gain - slack) {
        base[j] = Base::kLower;
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
