#include "simgap/fit/dynamics/base_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kWeakest = 1e-11;  // of the largest eigenvalue of the scaled normal matrix
constexpr double kPart = 0.1;       // of a direction that the log does not determine
constexpr double kRounding = 1e-9;  // of the effort's squares: finer no rigid body is known to explain a log

NormalEquations normalEquations(const DynamicsData& data, const std::vector<JointSums>& sums,
                                const std::vector<double>& variance, const std::vector<double>& constants) {
  const Index count = std::ssize(data.base.columns);
  NormalEquations all{MatrixXd::Zero(count, count), VectorXd::Zero(count)};
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const std::vector<std::size_t>& acts = data.base.acts[c];
    const MatrixXd& p = sums[c].products;
    const Index known = std::ssize(acts), effort = known + 1;
    for (Index i = 0; i < known; ++i) {
      const Index row = acts[i];
      for (Index k = 0; k < known; ++k) all.a(row, acts[k]) += p(i, k) / variance[c];
      all.b[row] += (constants[c] * p(i, effort) - p(i, known)) / variance[c];
    }
  }
  return all;
}

}  // namespace

MatrixXd weighedInverse(const MatrixXd& a, std::vector<bool>* determined) {
  const Index count = a.rows();
  VectorXd scale = a.diagonal().cwiseSqrt();
  for (double& s : scale) s = s > 0.0 ? 1.0 / s : 0.0;
  const SymmetricEigen eigen = symmetricEigen(scale.asDiagonal() * a * scale.asDiagonal());
  MatrixXd inverse = MatrixXd::Zero(count, count);
  if (determined) determined->assign(count, true);
  for (Index k = 0; k < count; ++k) {
    const VectorXd v = eigen.vectors.col(k);
    if (eigen.values[k] > kWeakest * eigen.values[count - 1]) {
      const VectorXd direction = scale.cwiseProduct(v);
      inverse += direction * direction.transpose() / eigen.values[k];
      continue;
    }
    for (Index i = 0; determined && i < count; ++i) {
      if (std::abs(v[i]) > kPart) (*determined)[i] = false;
    }
  }
  return inverse;
}

MatrixXd jackknifeOver(const MatrixXd& inverse, std::size_t blocks,
                       const std::function<NormalEquations(std::size_t block)>& of_block) {
  const Index count = inverse.rows();
  MatrixXd covariance = MatrixXd::Zero(count, count);
  double used = 0.0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const NormalEquations own = of_block(b);
    if (own.a.diagonal().maxCoeff() == 0.0) continue;
    const MatrixXd rest = MatrixXd::Identity(count, count) - own.a * inverse;
    VectorXd move = inverse * rest.partialPivLu().solve(own.b);
    if (!move.allFinite()) move = inverse * own.b;
    covariance += move * move.transpose();
    ++used;
  }
  return covariance * (used > 1.0 ? (used - 1.0) / used : 1.0);
}

VectorXd baseInFile(const DynamicsData& data) {
  VectorXd file = VectorXd::Zero(data.regressor.columns());
  file.segment(data.regressor.bodyColumn(0), data.regressor.dynamics().parameters()) =
      data.regressor.dynamics().parametersOf(data.arm);
  return data.base.combination * file;
}

double squaredError(const JointSums& sums, const std::vector<std::size_t>& acts, const VectorXd& x, double constant) {
  VectorXd v(sums.products.cols());
  const Index known = std::ssize(acts);
  for (Index i = 0; i < known; ++i) v[i] = -x[acts[i]];
  v[known] = -1.0;
  v[known + 1] = constant;
  return std::max(0.0, v.dot(sums.products * v));
}

BaseSolution solveBase(const DynamicsData& data, const std::vector<JointSums>& sums,
                       const std::vector<double>& constants) {
  constexpr int kPasses = 4;
  BaseSolution solution;
  solution.variance.assign(sums.size(), 1.0);
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const double squares = constants[c] * constants[c] * sums[c].effortSquares();
    solution.variance[c] = squares > 0.0 ? squares / std::max(sums[c].rows, 1.0) : 1.0;
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    const NormalEquations equations = normalEquations(data, sums, solution.variance, constants);
    solution.inverse = weighedInverse(equations.a, &solution.determined);
    solution.x = solution.inverse * equations.b;
    for (std::size_t c = 0; c < sums.size(); ++c) {
      if (sums[c].rows == 0.0) continue;
      const double squares = constants[c] * constants[c] * sums[c].effortSquares();
      const double error = squaredError(sums[c], data.base.acts[c], solution.x, constants[c]);
      const double free = std::max(1.0, sums[c].rows - static_cast<double>(data.base.acts[c].size()));
      solution.variance[c] = std::max(error, kRounding * squares) / free;
    }
  }
  return solution;
}

MatrixXd jackknifeCovariance(const DynamicsData& data, const BaseSolution& solution,
                             const std::vector<double>& constants, const std::vector<bool>& used) {
  return jackknifeOver(solution.inverse, used.size(), [&](std::size_t b) {
    const Index count = solution.x.size();
    if (!used[b]) return NormalEquations{MatrixXd::Zero(count, count), VectorXd::Zero(count)};
    NormalEquations own = normalEquations(data, data.sums.blocks[b], solution.variance, constants);
    own.b -= own.a * solution.x;
    return own;
  });
}

double inflationOf(const DynamicsData& data, const std::vector<JointSums>& sums, const BaseSolution& solution,
                   const MatrixXd& covariance) {
  const std::vector<double> ones(sums.size(), 1.0);
  const NormalEquations equations = normalEquations(data, sums, solution.variance, ones);
  const auto count = static_cast<double>(std::ranges::count(solution.determined, true));
  if (count == 0.0) return 1.0;
  return std::max(1.0, (equations.a * covariance).trace() / count);
}

VectorXd fitAlone(const DynamicsData& data, const JointSums& sums, std::size_t joint) {
  const Index own = 1 + std::ssize(data.regressor.law().terms);
  const std::vector<std::size_t>& acts = data.base.acts[joint];
  std::vector<Index> places;
  for (Index i = 0; i < std::ssize(acts); ++i) {
    const Index column = data.base.columns[acts[i]] - data.regressor.offsetColumn(joint);
    if (column >= 0 && column < own) places.push_back(i);
  }
  const Index effort = sums.products.cols() - 1;
  VectorXd found = VectorXd::Zero(sums.products.cols());
  const MatrixXd a = sums.products(places, places);
  const VectorXd diagonal = a.diagonal();
  if (places.empty() || diagonal.maxCoeff() == 0.0) return found;
  // Almost nothing holds a column that is 0 throughout: its factor stays 0.
  const MatrixXd held = a + MatrixXd(1e-12 * diagonal.maxCoeff() * MatrixXd::Identity(a.rows(), a.cols()));
  found(places) = solveLeastSquares(held, sums.products(places, effort));
  return found;
}

double squaredErrorAlone(const JointSums& sums, const VectorXd& own) {
  VectorXd v = -own;
  v[v.size() - 1] = 1.0;
  return std::max(0.0, v.dot(sums.products * v));
}

}  // namespace simgap
