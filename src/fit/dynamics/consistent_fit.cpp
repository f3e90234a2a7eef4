#include "consistent_fit.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"
#include "simgap/optimize/least_squares.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// How well a drawing is known: masses to a factor of 2, lengths of second moments to one of 1.5, and centres to half of
// the body's size. A log of some seconds outweighs this wherever it says anything.
constexpr double kMassSd = 0.35, kMomentSd = 0.4, kCentreSd = 0.5;

/// A factor F of a joint's sums, F^T F = products / variance.
MatrixXd factorOf(const MatrixXd& products, double variance) {
  const VectorXd scale = products.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const VectorXd back = products.diagonal().cwiseSqrt();
  const SymmetricEigen eigen = symmetricEigen(scale.asDiagonal() * products * scale.asDiagonal());
  const VectorXd roots = eigen.values.cwiseMax(0.0).cwiseSqrt() / std::sqrt(variance);
  return roots.asDiagonal() * eigen.vectors.transpose() * back.asDiagonal();
}

/// Where the numbers that are searched stand: per body with mass ten, per joint offset, friction and rotor.
class Layout {
 public:
  explicit Layout(const RobotRegressor& regressor) : regressor_(regressor) {
    for (std::size_t b = 0; b < regressor.bodies(); ++b) {
      if (!regressor.massless(b)) bodies_.push_back(b);
    }
  }
  const std::vector<std::size_t>& bodies() const { return bodies_; }
  Index body(std::size_t place) const { return kBodyParameters * static_cast<Index>(place); }
  Index own() const { return 1 + std::ssize(regressor_.law().terms); }
  Index drive(std::size_t c) const { return body(bodies_.size()) + (own() + 1) * static_cast<Index>(c); }
  Index size() const { return drive(regressor_.coordinates()); }

  /// All parameters, shape (P), and, unless null, their derivatives, shape (P, size).
  VectorXd parameters(const Eigen::Ref<const VectorXd>& theta, MatrixXd* jacobian) const {
    VectorXd p = VectorXd::Zero(regressor_.columns());
    if (jacobian != nullptr) jacobian->setZero(regressor_.columns(), size());
    BodyJacobian slopes;
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const Index column = regressor_.bodyColumn(bodies_[k]);
      p.segment<kBodyParameters>(column) =
          bodyOf(theta.segment<kBodyParameters>(body(k)), jacobian != nullptr ? &slopes : nullptr);
      if (jacobian != nullptr) jacobian->block<kBodyParameters, kBodyParameters>(column, body(k)) = slopes;
    }
    for (std::size_t c = 0; c < regressor_.coordinates(); ++c) {
      p.segment(regressor_.offsetColumn(c), own()) = theta.segment(drive(c), own());
      p[regressor_.rotorColumn(c)] = theta[drive(c) + own()];
      if (jacobian == nullptr) continue;
      jacobian->block(regressor_.offsetColumn(c), drive(c), own(), own()).setIdentity();
      (*jacobian)(regressor_.rotorColumn(c), drive(c) + own()) = 1.0;
    }
    return p;
  }

 private:
  const RobotRegressor& regressor_;
  std::vector<std::size_t> bodies_;
};

/// What is known before the log: theta = mean -+ sd.
struct Priors {
  VectorXd mean, sd;
};

Priors priorsOf(const DynamicsData& data, const std::vector<JointSums>& sums, const Layout& layout,
                const std::vector<double>& constants) {
  Priors priors{VectorXd::Zero(layout.size()), VectorXd::Ones(layout.size())};
  const VectorXd file = data.regressor.dynamics().parametersOf(data.arm);
  for (std::size_t k = 0; k < layout.bodies().size(); ++k) {
    const BodyParameters pi = file.segment<kBodyParameters>(kBodyParameters * static_cast<Index>(layout.bodies()[k]));
    const LogCholesky theta = logCholeskyOf(pi);
    const double size = std::sqrt((theta.segment<3>(1).array() * 2.0).exp().sum() + theta.segment<3>(7).squaredNorm());
    LogCholesky sd;
    sd << kMassSd, kMomentSd, kMomentSd, kMomentSd, LogCholesky::Constant(kCentreSd * size).tail<6>();
    priors.mean.segment<kBodyParameters>(layout.body(k)) = theta;
    priors.sd.segment<kBodyParameters>(layout.body(k)) = sd;
  }
  // Of a drive nothing is known but that its friction and its rotor alone do not exceed what the joint exerts.
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const std::vector<std::size_t>& acts = data.base.acts[c];
    const MatrixXd& p = sums[c].products;
    const double effort = constants[c] * std::sqrt(sums[c].effortSquares() / std::max(1.0, sums[c].rows));
    for (Index i = 0; i <= layout.own(); ++i) {
      const Index column = i < layout.own() ? data.regressor.offsetColumn(c) + i : data.regressor.rotorColumn(c);
      double size = 1.0;  // of a column that the base does not keep
      for (Index k = 0; k < std::ssize(acts); ++k) {
        if (data.base.columns[acts[k]] == column) size = std::sqrt(p(k, k) / std::max(1.0, sums[c].rows));
      }
      priors.sd[layout.drive(c) + i] = std::max(effort, 1e-9) / std::max(size, 1e-9);
    }
  }
  return priors;
}

class ConsistentProblem {
 public:
  ConsistentProblem(const DynamicsData& data, const std::vector<JointSums>& sums, const std::vector<double>& variance,
                    double inflation, const std::vector<double>& constants)
      : data_(data), layout_(data.regressor), priors_(priorsOf(data, sums, layout_, constants)), constants_(constants) {
    for (std::size_t c = 0; c < sums.size(); ++c)
      factors_.push_back(factorOf(sums[c].products, inflation * variance[c]));
  }

  const Layout& layout() const { return layout_; }
  const Priors& priors() const { return priors_; }

  LeastSquaresProblem problem() const {
    LeastSquaresProblem problem;
    Index rows = layout_.size();
    for (const MatrixXd& factor : factors_) rows += factor.rows();
    problem.chunks = {{0, static_cast<std::size_t>(rows)}};
    problem.parameters.resize(layout_.size());
    for (std::size_t c = 0; c < factors_.size(); ++c) {
      for (Index i = 1; i <= layout_.own(); ++i) problem.parameters[layout_.drive(c) + i].lower = 0.0;
    }
    problem.evaluate = [this](std::span<const double> theta, const Block&, Eigen::Ref<VectorXd> residual,
                              Eigen::Ref<MatrixXd>* jacobian) { evaluate(theta, residual, jacobian); };
    return problem;
  }

 private:
  void evaluate(std::span<const double> values, Eigen::Ref<VectorXd> residual, Eigen::Ref<MatrixXd>* jacobian) const {
    const Eigen::Map<const VectorXd> theta(values.data(), std::ssize(values));
    MatrixXd slopes;
    const VectorXd p = layout_.parameters(theta, jacobian != nullptr ? &slopes : nullptr);
    const VectorXd x = data_.base.combination * p;
    if (jacobian != nullptr) {
      jacobian->setZero();
      slopes = (data_.base.combination * slopes).eval();  // shape (K, size)
    }
    Index row = 0;
    for (std::size_t c = 0; c < factors_.size(); ++c) {
      const MatrixXd& f = factors_[c];
      const std::vector<std::size_t>& acts = data_.base.acts[c];
      const Index known = std::ssize(acts), rows = f.rows();
      VectorXd v(known + 2);
      for (Index i = 0; i < known; ++i) v[i] = -x[acts[i]];
      v[known] = -1.0;
      v[known + 1] = constants_[c];
      residual.segment(row, rows) = f * v;
      if (jacobian != nullptr) jacobian->middleRows(row, rows) = -f.leftCols(known) * slopes(acts, Eigen::all);
      row += rows;
    }
    residual.tail(layout_.size()) = (theta - priors_.mean).cwiseQuotient(priors_.sd);
    if (jacobian != nullptr) jacobian->bottomRows(layout_.size()).diagonal() = priors_.sd.cwiseInverse();
  }

  const DynamicsData& data_;
  Layout layout_;
  Priors priors_;
  std::vector<double> constants_;
  std::vector<MatrixXd> factors_;
};

}  // namespace

ConsistentFit fitConsistent(const DynamicsData& data, const std::vector<JointSums>& sums,
                            const std::vector<double>& variance, double inflation,
                            const std::vector<double>& constants) {
  LeastSquaresOptions options;
  options.max_iterations = 300;
  options.function_tolerance = 1e-8;  // the cost is a chi squared: of a thousand, 1e-5 means nothing
  options.parameter_tolerance = 1e-8;
  LeastSquaresOptions in_planes = options;
  in_planes.dogleg = true;
  // A sharp log makes a narrow, curved valley of bodies that explain it: the way there begins where the priors rule,
  // and follows the valley as the log gains weight.
  LeastSquaresResult result;
  for (const double weight : {1e4, 1e3, 1e2, 10.0, 1.0}) {
    const ConsistentProblem relaxed(data, sums, variance, weight * inflation, constants);
    const VectorXd& mean = relaxed.priors().mean;
    if (result.theta.empty()) result.theta.assign(mean.begin(), mean.end());
    result = minimise(relaxed.problem(), result.theta, options);
    if (!result.converged) result = minimise(relaxed.problem(), result.theta, in_planes);  // its steps crept
  }
  const ConsistentProblem search(data, sums, variance, inflation, constants);
  const LeastSquaresProblem problem = search.problem();
  const Layout& layout = search.layout();
  const Eigen::Map<const VectorXd> theta(result.theta.data(), layout.size());

  ConsistentFit fit;
  fit.converged = result.converged;
  MatrixXd slopes;
  fit.parameters = layout.parameters(theta, &slopes);
  const Linearisation at = linearise(problem, result.theta, problem.chunks);
  const MatrixXd covariance = inverse(at.factor.transpose() * at.factor);
  const auto deviations = [&](const MatrixXd& of) {
    return VectorXd((slopes * of * slopes.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt());
  };
  fit.sd = deviations(covariance);
  const MatrixXd base_slopes = data.base.combination * slopes;
  fit.base_covariance = base_slopes * covariance * base_slopes.transpose();
  fit.prior_sd = deviations(MatrixXd(search.priors().sd.cwiseAbs2().asDiagonal()));
  return fit;
}

}  // namespace simgap
