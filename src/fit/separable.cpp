#include "simgap/fit/separable.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

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

/// The grid of one non-linear term.
std::vector<double> axis(const NonlinearTerm& term) {
  if (term.lower == term.upper) return {term.lower};
  std::vector<double> values(static_cast<std::size_t>(term.grid));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(values.size() - 1);
    values[i] = term.logarithmic ? term.lower * std::pow(term.upper / term.lower, t)
                                 : term.lower + t * (term.upper - term.lower);
  }
  return values;
}

SeparableMinimum evaluate(const SeparableProblem& problem, std::span<const double> p) {
  return {{p.begin(), p.end()}, solveBounded(problem.gram(p), problem.linear)};
}

/// Steps through all points of a grid.
std::vector<double> pointAt(const CostProfile& profile, std::size_t index) {
  std::vector<double> p(profile.axes.size());
  for (std::size_t a = p.size(); a-- > 0;) {
    p[a] = profile.axes[a][index % profile.axes[a].size()];
    index /= profile.axes[a].size();
  }
  return p;
}

/// Grid points none of whose neighbours along any combination of axes is lower, lowest first.
std::vector<std::size_t> localMinima(const CostProfile& profile) {
  std::vector<std::size_t> found;
  const std::size_t dimensions = profile.axes.size();
  for (std::size_t i = 0; i < profile.cost.size(); ++i) {
    bool lowest = std::isfinite(profile.cost[i]);
    const auto neighbours = static_cast<std::size_t>(std::pow(3, dimensions));
    for (std::size_t code = 0; code < neighbours && lowest; ++code) {
      std::size_t rest = code, stride = 1, place = i;
      std::ptrdiff_t other = static_cast<std::ptrdiff_t>(i);
      bool inside = true;
      for (std::size_t a = dimensions; a-- > 0;) {
        const std::size_t size = profile.axes[a].size();
        const std::ptrdiff_t step = static_cast<std::ptrdiff_t>(rest % 3) - 1;
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(place % size) + step;
        inside = inside && at >= 0 && at < static_cast<std::ptrdiff_t>(size);
        other += step * static_cast<std::ptrdiff_t>(stride);
        rest /= 3;
        place /= size;
        stride *= size;
      }
      if (inside && profile.cost[static_cast<std::size_t>(other)] < profile.cost[i]) lowest = false;
    }
    if (lowest) found.push_back(i);
  }
  std::ranges::stable_sort(found, {}, [&](std::size_t i) { return profile.cost[i]; });
  return found;
}

bool same(const SeparableMinimum& a, const SeparableMinimum& b, std::span<const NonlinearTerm> terms) {
  const double cost = std::max(a.linear.cost, b.linear.cost);
  if (std::abs(a.linear.cost - b.linear.cost) > 1e-5 * cost) return false;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const double scale = terms[i].logarithmic ? std::max(a.p[i], b.p[i]) : terms[i].upper - terms[i].lower;
    if (std::abs(a.p[i] - b.p[i]) > 0.05 * scale) return false;
  }
  return true;
}

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

SeparableMinimum refineSeparable(const SeparableProblem& problem, std::span<const double> start) {
  // In scaled coordinates: the box is the unit cube.
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < problem.nonlinear.size(); ++i) {
    if (problem.nonlinear[i].lower < problem.nonlinear[i].upper) free.push_back(i);
  }
  if (free.empty()) return evaluate(problem, start);
  using Point = std::array<double, 3>;
  const auto toBox = [&](const Point& u) {
    std::vector<double> p(start.begin(), start.end());
    for (std::size_t k = 0; k < free.size(); ++k) {
      const NonlinearTerm& term = problem.nonlinear[free[k]];
      const double t = std::clamp(u[k], 0.0, 1.0);
      p[free[k]] = term.logarithmic ? term.lower * std::pow(term.upper / term.lower, t)
                                    : term.lower + t * (term.upper - term.lower);
    }
    return p;
  };
  const auto cost = [&](Point& u) {
    for (std::size_t k = 0; k < free.size(); ++k) u[k] = std::clamp(u[k], 0.0, 1.0);
    return solveBounded(problem.gram(toBox(u)), problem.linear).cost;
  };
  struct Vertex {
    Point u;
    double cost;
  };
  std::vector<Vertex> simplex;
  Point first{};
  for (std::size_t k = 0; k < free.size(); ++k) {
    const NonlinearTerm& term = problem.nonlinear[free[k]];
    const double value = std::clamp(start[free[k]], term.lower, term.upper);
    first[k] = term.logarithmic ? std::log(value / term.lower) / std::log(term.upper / term.lower)
                                : (value - term.lower) / (term.upper - term.lower);
  }
  for (std::size_t k = 0; k <= free.size(); ++k) {
    Point u = first;
    if (k > 0) u[k - 1] += (u[k - 1] < 0.5 ? 0.5 : -0.5) / problem.nonlinear[free[k - 1]].grid;
    const double value = cost(u);
    simplex.push_back({u, value});
  }
  const auto blend = [&](const Point& a, const Point& b, double t) {
    Point u{};
    for (std::size_t k = 0; k < free.size(); ++k) u[k] = a[k] + t * (b[k] - a[k]);
    return u;
  };
  for (int iteration = 0; iteration < 200; ++iteration) {
    std::ranges::stable_sort(simplex, {}, &Vertex::cost);
    double width = 0.0;
    for (std::size_t k = 0; k < free.size(); ++k) {
      for (const Vertex& v : simplex) width = std::max(width, std::abs(v.u[k] - simplex[0].u[k]));
    }
    if (width < 1e-7 || simplex.back().cost - simplex[0].cost <= 1e-12 * simplex[0].cost) break;
    Point centre{};
    for (std::size_t k = 0; k < free.size(); ++k) {
      for (std::size_t v = 0; v + 1 < simplex.size(); ++v) centre[k] += simplex[v].u[k];
      centre[k] /= static_cast<double>(simplex.size() - 1);
    }
    Vertex& worst = simplex.back();
    const auto attempt = [&](double t) {
      Point u = blend(centre, worst.u, t);
      const double value = cost(u);
      return Vertex{u, value};
    };
    const Vertex reflected = attempt(-1.0);
    if (reflected.cost < simplex[0].cost) {
      const Vertex expanded = attempt(-2.0);
      worst = expanded.cost < reflected.cost ? expanded : reflected;
    } else if (reflected.cost < simplex[simplex.size() - 2].cost) {
      worst = reflected;
    } else {
      const Vertex contracted = attempt(reflected.cost < worst.cost ? -0.5 : 0.5);
      if (contracted.cost < std::min(worst.cost, reflected.cost)) {
        worst = contracted;
      } else {
        for (std::size_t v = 1; v < simplex.size(); ++v) {
          Point u = blend(simplex[0].u, simplex[v].u, 0.5);
          const double value = cost(u);
          simplex[v] = {u, value};
        }
      }
    }
  }
  std::ranges::stable_sort(simplex, {}, &Vertex::cost);
  return evaluate(problem, toBox(simplex[0].u));
}

SeparableResult searchSeparable(const SeparableProblem& problem) {
  constexpr std::size_t kMostMinima = 8;  // the lowest ones are refined
  SeparableResult result;
  std::size_t points = 1;
  for (const NonlinearTerm& term : problem.nonlinear) {
    result.profile.axes.push_back(axis(term));
    points *= result.profile.axes.back().size();
  }
  result.starts = points;
  result.profile.cost.resize(points);
  tbb::parallel_for(std::size_t{0}, points, [&](std::size_t i) {
    result.profile.cost[i] = evaluate(problem, pointAt(result.profile, i)).linear.cost;
  });
  std::vector<std::size_t> starts = localMinima(result.profile);
  starts.resize(std::min(starts.size(), kMostMinima));
  std::vector<SeparableMinimum> refined(starts.size());
  tbb::parallel_for(std::size_t{0}, starts.size(),
                    [&](std::size_t i) { refined[i] = refineSeparable(problem, pointAt(result.profile, starts[i])); });
  std::ranges::stable_sort(refined, {}, [](const SeparableMinimum& m) { return m.linear.cost; });
  for (const SeparableMinimum& candidate : refined) {
    const bool known = std::ranges::any_of(
        result.minima, [&](const SeparableMinimum& m) { return same(m, candidate, problem.nonlinear); });
    if (!known) result.minima.push_back(candidate);
  }
  return result;
}

}  // namespace simgap
