/// \file
/// Separable least squares (variable projection: Golub & Pereyra 1973): y ~ X(p) c with few non-linear numbers p. For
/// given p the rest is a bounded linear least squares that its normal matrix answers; p is searched on a grid over its
/// whole box and refined from every local minimum of the grid, so that the global minimum is found and can be shown.
///
/// A model says what its columns are and how to sum their products; the products may be summed over all rows or over
/// the rows of some folds, which is what cross-validation needs.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace simgap {

/// A coefficient. In a model with a gain (column 0) a physical parameter theta enters as c = theta * gain: its bounds
/// then hold for c / c_0.
struct LinearTerm {
  std::string name;
  double lower = 0.0;
  double upper = std::numeric_limits<double>::infinity();
  bool times_gain = false;
};

/// A number that enters the columns non-linearly.
struct NonlinearTerm {
  std::string name;
  double lower;
  double upper;
  bool logarithmic = true;  ///< searched on a logarithmic scale
  int grid = 32;            ///< points over the box
  /// The largest step on that scale (of the logarithm) over which the columns change little, at p. Where it is smaller
  /// than the grid's, the grid of the first term and the first simplex of its refinement become finer.
  std::function<double(std::span<const double> p)> step = {};
};

struct SeparableProblem {
  std::vector<LinearTerm> linear;        ///< shape (C)
  std::vector<NonlinearTerm> nonlinear;  ///< shape (P), P <= 3
  /// The normal matrix of [X(p) y], shape (C + 1, C + 1). Called from several threads at once.
  std::function<Eigen::MatrixXd(std::span<const double> p)> gram;
};

struct LinearSolution {
  Eigen::VectorXd coefficients;  ///< shape (C)
  double cost = 0.0;             ///< sum of squares
};

/// min |y - X c|^2 within the terms' bounds, from the normal matrix of [X y].
LinearSolution solveBounded(const Eigen::MatrixXd& gram, std::span<const LinearTerm> terms);

/// Cost over the grid of the non-linear terms: the picture of how well they are determined.
struct CostProfile {
  std::vector<std::vector<double>> axes;  ///< shape (P, grid)
  std::vector<double> cost;               ///< shape (product of grids), the last axis runs fastest
  /// The non-linear terms where cost[place] is, shape (P).
  std::vector<double> at(std::size_t place) const;
};

struct SeparableMinimum {
  std::vector<double> p;
  LinearSolution linear;
};

struct SeparableResult {
  std::vector<SeparableMinimum> minima;  ///< distinct local minima, the best first
  CostProfile profile;
  std::size_t starts = 0;  ///< grid points tried
};

/// Searches the whole box.
SeparableResult searchSeparable(const SeparableProblem& problem);

/// Refines p from a start by the simplex of Nelder & Mead (1965) within the box.
SeparableMinimum refineSeparable(const SeparableProblem& problem, std::span<const double> start);

}  // namespace simgap
