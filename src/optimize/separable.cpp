/// Variable projection: V(p) = min_c |y - X(p) c|^2 is a function of the few non-linear numbers alone. Its value takes
/// a normal matrix and a small bounded solve; where bounds on c come into play it has kinks, and where the rows have
/// gaps of speed narrow valleys. So it is searched by values: on a grid, then by simplices.
#include "simgap/optimize/separable.h"

#include <nlopt.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>

#include "simgap/core/error.h"

namespace simgap {
namespace {

/// A number in [0, 1] on the scale of a non-linear term, and back.
double fromUnit(const NonlinearTerm& term, double t) {
  return term.logarithmic ? term.lower * std::pow(term.upper / term.lower, t)
                          : term.lower + t * (term.upper - term.lower);
}

double toUnit(const NonlinearTerm& term, double value) {
  value = std::clamp(value, term.lower, term.upper);
  return term.logarithmic ? std::log(value / term.lower) / std::log(term.upper / term.lower)
                          : (value - term.lower) / (term.upper - term.lower);
}

/// Cells of the grid over one non-linear term.
std::size_t cells(const NonlinearTerm& term) {
  return term.lower == term.upper ? 0 : static_cast<std::size_t>(term.grid) - 1;
}

/// The step at p that resolves the columns, in cells of the grid; 1 when the grid does.
double stepInCells(const NonlinearTerm& term, std::span<const double> p) {
  if (!term.step || cells(term) == 0) return 1.0;
  const double range = term.logarithmic ? std::log(term.upper / term.lower) : term.upper - term.lower;
  return std::min(1.0, term.step(p) / range * static_cast<double>(cells(term)));
}

SeparableMinimum evaluate(const SeparableProblem& problem, std::span<const double> p) {
  return {{p.begin(), p.end()}, solveBounded(problem.gram(p), problem.linear)};
}

/// The grid: lines along the first term, one for each combination of the others. A line divides each cell of its term
/// into a power of two of parts, as many as resolve the columns there.
class Grid {
 public:
  explicit Grid(const SeparableProblem& problem) : problem_(problem) {
    for (const NonlinearTerm& term : problem.nonlinear) {
      std::vector<double>& axis = profile_.axes.emplace_back();
      for (std::size_t i = 0; i <= cells(term); ++i) axis.push_back(valueAt(term, static_cast<double>(i), 1));
    }
    std::size_t lines = 1;
    for (std::size_t a = 1; a < profile_.axes.size(); ++a) lines *= profile_.axes[a].size();
    for (std::size_t l = 0; l < lines; ++l) {
      std::vector<double> p(problem.nonlinear.size());
      for (std::size_t a = p.size(), rest = l; a-- > 1; rest /= profile_.axes[a].size()) {
        p[a] = profile_.axes[a][rest % profile_.axes[a].size()];
      }
      Line line{p, 1, points_, {}};
      if (!p.empty()) {
        const NonlinearTerm& along = problem.nonlinear[0];
        line.p[0] = along.lower;
        line.parts = std::bit_ceil(static_cast<std::size_t>(std::ceil(1.0 / stepInCells(along, line.p))));
        line.cost.resize(cells(along) * line.parts + 1);
      } else {
        line.cost.resize(1);
      }
      points_ += line.cost.size();
      lines_.push_back(std::move(line));
    }
  }

  std::size_t points() const { return points_; }

  void evaluateAll() {
    tbb::parallel_for(std::size_t{0}, points_, [&](std::size_t point) {
      const auto after = std::ranges::upper_bound(lines_, point, {}, &Line::first);
      Line& line = *(after - 1);
      const std::size_t i = point - line.first;
      line.cost[i] = evaluate(problem_, at(line, i)).linear.cost;
    });
  }

  /// The points of whole cells.
  CostProfile profile() const {
    CostProfile result = profile_;
    const std::size_t whole = result.axes.empty() ? 1 : result.axes[0].size();
    for (std::size_t i = 0; i < whole; ++i) {
      for (const Line& line : lines_) result.cost.push_back(line.cost[i * line.parts]);
    }
    return result;
  }

  /// Points none of whose neighbours, along any combination of axes, is lower; lowest first. A plateau counts once.
  std::vector<std::vector<double>> localMinima(std::size_t most) const {
    struct Found {
      double cost;
      std::size_t line, i;
    };
    std::vector<Found> found;
    for (std::size_t l = 0; l < lines_.size(); ++l) {
      const std::vector<std::size_t> beside = neighbours(l);
      for (std::size_t i = 0; i < lines_[l].cost.size(); ++i) {
        if (isLowest(l, i, beside)) found.push_back({lines_[l].cost[i], l, i});
      }
    }
    std::ranges::stable_sort(found, {}, &Found::cost);
    std::vector<std::vector<double>> points;
    for (const Found& f : found) {
      if (points.size() < most) points.push_back(at(lines_[f.line], f.i));
    }
    return points;
  }

 private:
  struct Line {
    std::vector<double> p;     ///< shape (P): of its first point
    std::size_t parts;         ///< of every cell
    std::size_t first;         ///< number of its first point
    std::vector<double> cost;  ///< shape (cells * parts + 1)
  };

  static double valueAt(const NonlinearTerm& term, double i, std::size_t parts) {
    if (cells(term) == 0) return term.lower;
    return fromUnit(term, i / static_cast<double>(cells(term) * parts));
  }

  std::vector<double> at(const Line& line, std::size_t i) const {
    std::vector<double> p = line.p;
    if (!p.empty()) p[0] = valueAt(problem_.nonlinear[0], static_cast<double>(i), line.parts);
    return p;
  }

  /// Lines one step away along any combination of the other axes, and the line itself.
  std::vector<std::size_t> neighbours(std::size_t line) const {
    std::vector<std::size_t> all{0};
    std::size_t stride = lines_.size(), rest = line;
    for (std::size_t a = 1; a < profile_.axes.size(); ++a) {
      const std::size_t size = profile_.axes[a].size();
      stride /= size;
      const std::size_t place = rest / stride;
      rest %= stride;
      std::vector<std::size_t> more;
      for (const std::size_t before : all) {
        for (std::size_t k = place > 0 ? place - 1 : 0; k <= std::min(place + 1, size - 1); ++k) {
          more.push_back(before + k * stride);
        }
      }
      all = std::move(more);
    }
    return all;
  }

  bool isLowest(std::size_t l, std::size_t i, const std::vector<std::size_t>& beside) const {
    const Line& own = lines_[l];
    if (!std::isfinite(own.cost[i])) return false;
    for (const std::size_t b : beside) {
      const Line& other = lines_[b];
      // One step of the coarser of the two lines to either side, in parts of the other line.
      const double here = static_cast<double>(i * other.parts) / static_cast<double>(own.parts);
      const double step = static_cast<double>(other.parts) / static_cast<double>(std::min(own.parts, other.parts));
      const auto from = static_cast<std::size_t>(std::ceil(std::max(here - step, 0.0)));
      const auto to = static_cast<std::size_t>(std::min(here + step, static_cast<double>(other.cost.size() - 1)));
      for (std::size_t k = from; k <= to; ++k) {
        const bool earlier = b < l || (b == l && k < i);
        if (other.cost[k] < own.cost[i] || (earlier && other.cost[k] == own.cost[i])) return false;
      }
    }
    return true;
  }

  const SeparableProblem& problem_;
  CostProfile profile_;  ///< without costs
  std::vector<Line> lines_;
  std::size_t points_ = 0;
};

bool same(const SeparableMinimum& a, const SeparableMinimum& b, std::span<const NonlinearTerm> terms) {
  const double cost = std::max(a.linear.cost, b.linear.cost);
  if (std::abs(a.linear.cost - b.linear.cost) > 1e-5 * cost) return false;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const double scale = terms[i].logarithmic ? std::max(a.p[i], b.p[i]) : terms[i].upper - terms[i].lower;
    if (std::abs(a.p[i] - b.p[i]) > 0.05 * scale) return false;
  }
  return true;
}

/// The simplex of Nelder & Mead (1965) in the unit cube, as NLopt has it. \param edge  of the first simplex, per
/// coordinate. \param tolerance  of the cost, relative: what the simplex spans when it ends.
/// \param at  where to start; left at the best point  shape (free parameters), as `edge`
void descend(const std::function<double(const double*)>& cost, const std::vector<double>& edge, double tolerance,
             std::vector<double>& at) {
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> simplex(
      nlopt_create(NLOPT_LN_NELDERMEAD, static_cast<unsigned>(at.size())), nlopt_destroy);
  const auto call = [](unsigned /*n*/, const double* u, double* /*gradient*/, void* data) {
    return (*static_cast<const std::function<double(const double*)>*>(data))(u);
  };
  nlopt_set_min_objective(simplex.get(), call, const_cast<std::function<double(const double*)>*>(&cost));
  nlopt_set_lower_bounds1(simplex.get(), 0.0);
  nlopt_set_upper_bounds1(simplex.get(), 1.0);
  nlopt_set_initial_step(simplex.get(), edge.data());
  nlopt_set_ftol_rel(simplex.get(), tolerance);
  nlopt_set_xtol_abs1(simplex.get(), 1e-8);
  nlopt_set_maxeval(simplex.get(), 500);
  double lowest = 0.0;
  nlopt_optimize(simplex.get(), at.data(), &lowest);
}

/// One descent from a start. \param edge  of the first simplex, in steps that resolve the columns.
SeparableMinimum descendFrom(const SeparableProblem& problem, std::span<const double> start, double edge,
                             double tolerance) {
  std::vector<std::size_t> free;
  std::vector<double> u, edges;
  for (std::size_t i = 0; i < problem.nonlinear.size(); ++i) {
    const NonlinearTerm& term = problem.nonlinear[i];
    if (cells(term) == 0) continue;
    u.push_back(std::clamp(toUnit(term, start[i]), 0.0, 1.0));
    edges.push_back(edge * stepInCells(term, start) / static_cast<double>(cells(term)));
    free.push_back(i);
  }
  if (free.empty()) return evaluate(problem, start);
  std::vector<double> p(start.begin(), start.end());
  const auto place = [&](const double* at) {
    for (std::size_t k = 0; k < free.size(); ++k) p[free[k]] = fromUnit(problem.nonlinear[free[k]], at[k]);
  };
  const auto cost = [&](const double* at) {
    place(at);
    return solveBounded(problem.gram(p), problem.linear).cost;
  };
  descend(cost, edges, tolerance, u);
  place(u.data());
  return evaluate(problem, p);
}

constexpr double kRough = 1e-6, kFine = 1e-13;  // of the cost

/// To the bottom. A simplex can collapse onto a bound or across a valley: a smaller one begins where the first ended.
SeparableMinimum finish(const SeparableProblem& problem, const SeparableMinimum& rough) {
  return descendFrom(problem, descendFrom(problem, rough.p, 0.1, kFine).p, 0.05, kFine);
}

}  // namespace

SeparableMinimum refineSeparable(const SeparableProblem& problem, std::span<const double> start) {
  return finish(problem, descendFrom(problem, start, 0.5, kRough));
}

std::vector<double> CostProfile::at(std::size_t place) const {
  std::vector<double> p(axes.size());
  for (std::size_t k = axes.size(); k-- > 0; place /= axes[k].size()) p[k] = axes[k][place % axes[k].size()];
  return p;
}

SeparableResult searchSeparable(const SeparableProblem& problem) {
  constexpr std::size_t kMostMinima = 16;  // the lowest ones are refined
  constexpr double kNear = 1.002;          // of the lowest cost: these to the bottom
  Grid grid(problem);
  grid.evaluateAll();
  SeparableResult result;
  result.profile = grid.profile();
  result.starts = grid.points();
  const std::vector<std::vector<double>> starts = grid.localMinima(kMostMinima);
  if (starts.empty())
    throw NumericsError("found no place of the search with a finite error: the columns are no numbers");
  std::vector<SeparableMinimum> refined(starts.size());
  tbb::parallel_for(std::size_t{0}, starts.size(),
                    [&](std::size_t i) { refined[i] = descendFrom(problem, starts[i], 0.5, kRough); });
  const auto cost = [](const SeparableMinimum& m) { return m.linear.cost; };
  // Roughly to each local minimum; only those that may be the lowest to the last digit.
  const double near = kNear * std::ranges::min(refined, {}, cost).linear.cost;
  tbb::parallel_for(std::size_t{0}, refined.size(), [&](std::size_t i) {
    if (refined[i].linear.cost <= near) refined[i] = finish(problem, refined[i]);
  });
  std::ranges::stable_sort(refined, {}, cost);
  for (const SeparableMinimum& candidate : refined) {
    const bool known = std::ranges::any_of(
        result.minima, [&](const SeparableMinimum& m) { return same(m, candidate, problem.nonlinear); });
    if (!known) result.minima.push_back(candidate);
  }
  return result;
}

}  // namespace simgap
