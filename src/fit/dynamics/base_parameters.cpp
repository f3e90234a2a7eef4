#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"
#include "simgap/core/random.h"
#include "simgap/fit/dynamics/robot_regressor.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDependent = 1e-8;   // of a column's length: what is left of one that others make up
constexpr double kNegligible = 1e-7;  // a factor that rounding has made

/// Positions all over the limits, speeds and accelerations of the order of one, in every direction.
RobotMotion randomMotion(const CounterRandom& random, const RobotRegressor& regressor, const ArmModel& model,
                         std::uint32_t draw) {
  constexpr double kFullTurn = 3.0;
  RobotMotion motion;
  for (std::uint32_t c = 0; c < regressor.coordinates(); ++c) {
    const Joint& joint = model.joints[regressor.dynamics().joints()[c]];
    const double lower = std::max(joint.lower_limit, -kFullTurn), upper = std::min(joint.upper_limit, kFullTurn);
    const auto number = [&](std::uint32_t purpose) { return random.uniform({draw, c, 0, purpose}); };
    motion.position.push_back(lower + (upper - lower) * number(0));
    motion.velocity.push_back(4.0 * number(1) - 2.0);
    motion.acceleration.push_back(10.0 * number(2) - 5.0);
    motion.direction.push_back(motion.velocity.back() > 0.0 ? 1.0 : -1.0);
  }
  return motion;
}

/// The regressor over random motions, shape (rows, P).
MatrixXd randomRows(const RobotRegressor& regressor, const ArmModel& model) {
  const Index n = regressor.coordinates(), p = regressor.columns();
  const Index states = 2 * p / n + 40;
  const CounterRandom random(1990);
  RobotRegressor::Workspace work = regressor.workspace();
  const std::vector<StribeckCurve> curves(regressor.coordinates());
  RegressorMatrix y(n, p);
  MatrixXd all(n * states, p);
  for (Index s = 0; s < states; ++s) {
    regressor.rows(randomMotion(random, regressor, model, static_cast<std::uint32_t>(s)), curves, work, y);
    all.middleRows(n * s, n) = y;
  }
  return all;
}

std::string combinationText(const RobotRegressor& regressor, const VectorXd& factors, Index kept) {
  std::string text = regressor.names()[kept];
  for (Index k = 0; k < factors.size(); ++k) {
    if (k == kept || factors[k] == 0.0) continue;
    const double size = std::abs(factors[k]);
    const std::string factor = std::abs(size - 1.0) < 1e-9 ? "" : fmt::format("{:.4g} ", size);
    text += fmt::format(" {} {}{}", factors[k] < 0.0 ? '-' : '+', factor, regressor.names()[k]);
  }
  return text;
}

}  // namespace

BaseParameters baseParameters(const RobotRegressor& regressor, const ArmModel& model) {
  const MatrixXd rows = randomRows(regressor, model);
  const Index p = rows.cols();
  const double largest = rows.colwise().norm().maxCoeff();
  BaseParameters base;
  std::vector<Index> others;
  // Gram and Schmidt, each column against those kept so far, twice against rounding (Daniel et al. 1976).
  MatrixXd q(rows.rows(), p);
  for (Index k = 0; k < p; ++k) {
    VectorXd left = rows.col(k);
    const double length = left.norm();
    if (length <= 1e-12 * largest) {
      base.without_effect.push_back(regressor.names()[k]);
      continue;
    }
    const Index kept = std::ssize(base.columns);
    for (int pass = 0; pass < 2; ++pass) left -= q.leftCols(kept) * (q.leftCols(kept).transpose() * left);
    if (left.norm() <= kDependent * length) {
      others.push_back(k);
      continue;
    }
    q.col(kept) = left.normalized();
    base.columns.push_back(k);
  }
  const MatrixXd kept_rows = rows(Eigen::all, base.columns);
  const Index count = std::ssize(base.columns);
  base.combination = MatrixXd::Zero(count, p);
  for (Index k = 0; k < count; ++k) base.combination(k, base.columns[k]) = 1.0;
  if (!others.empty()) {
    const MatrixXd factors = solveLeastSquares(kept_rows, rows(Eigen::all, others));
    for (std::size_t k = 0; k < others.size(); ++k) {
      base.combination.col(others[k]) =
          factors.col(k).unaryExpr([](double f) { return std::abs(f) > kNegligible ? f : 0.0; });
    }
  }
  const Index n = regressor.coordinates();
  base.acts.resize(regressor.coordinates());
  for (Index k = 0; k < count; ++k) {
    base.names.push_back(regressor.names()[base.columns[k]]);
    base.texts.push_back(combinationText(regressor, base.combination.row(k), base.columns[k]));
    for (Index c = 0; c < n; ++c) {
      const double size = kept_rows(Eigen::seq(c, Eigen::last, n), k).cwiseAbs().maxCoeff();
      if (size > kDependent * kept_rows.col(k).cwiseAbs().maxCoeff()) base.acts[c].push_back(k);
    }
  }
  return base;
}

}  // namespace simgap
