#include "simgap/fit/dynamics/torque_constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/dynamics/base_fit.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kHardly = 0.5;  // of a constant: half its interval, beyond which nobody knows it
constexpr double kUnlike = 3.0;  // times the file's masses: no robot was drawn that badly

/// z = (x, u) with u = 1 / k: the residual i - u ([Y, known] w), w = (x, 1), is linear in either.
class CurrentFit {
 public:
  explicit CurrentFit(const DynamicsData& data)
      : data_(data), base_(std::ssize(data.base.columns)), joints_(std::ssize(data.base.acts)) {}

  Index size() const { return base_ + joints_; }
  Index place(Index joint) const { return base_ + joint; }

  /// Gauss-Newton's matrix J^T J and gradient -J^T r of all joints, weighed.
  NormalEquations normal(const std::vector<JointSums>& sums, const VectorXd& z, const VectorXd& variance) const {
    NormalEquations all{MatrixXd::Zero(size(), size()), VectorXd::Zero(size())};
    for (Index c = 0; c < joints_; ++c) {
      const Joint j = joint(sums, z, c);
      const double u = z[place(c)], weight = 1.0 / variance[c];
      for (Index i = 0; i < j.known; ++i) {
        const Index row = acts(c)[i];
        for (Index k = 0; k < j.known; ++k) all.a(row, acts(c)[k]) += weight * u * u * j.torques(i, k);
        all.a(row, place(c)) += weight * u * j.of_w[i];
        all.a(place(c), row) += weight * u * j.of_w[i];
        all.b[row] += weight * u * (j.with_current[i] - u * j.of_w[i]);
      }
      all.a(place(c), place(c)) += weight * j.squares;
      all.b[place(c)] += weight * (j.product - u * j.squares);
    }
    return all;
  }
  /// Squared errors of the currents, shape (N).
  VectorXd errors(const std::vector<JointSums>& sums, const VectorXd& z) const {
    VectorXd errors(joints_);
    for (Index c = 0; c < joints_; ++c) {
      const Joint j = joint(sums, z, c);
      const double u = z[place(c)];
      errors[c] = std::max(0.0, sums[c].effortSquares() - 2.0 * u * j.product + u * u * j.squares);
    }
    return errors;
  }
  /// Least squares of k i - tau: linear in x and k, and near the truth where currents have little noise.
  VectorXd start(const std::vector<JointSums>& sums) const {
    NormalEquations all{MatrixXd::Zero(size(), size()), VectorXd::Zero(size())};
    for (Index c = 0; c < joints_; ++c) {
      const MatrixXd& p = sums[c].products;
      const Index known = std::ssize(acts(c)), effort = known + 1;
      const double weight = sums[c].rows / std::max(p(effort, effort), 1e-300);
      for (Index i = 0; i < known; ++i) {
        const Index row = acts(c)[i];
        for (Index k = 0; k < known; ++k) all.a(row, acts(c)[k]) += weight * p(i, k);
        all.a(row, place(c)) -= weight * p(i, effort);
        all.a(place(c), row) -= weight * p(i, effort);
        all.b[row] -= weight * p(i, known);
      }
      all.a(place(c), place(c)) += weight * p(effort, effort);
      all.b[place(c)] += weight * p(known, effort);
    }
    VectorXd z = weighedInverse(all.a) * all.b;
    const double largest = z.tail(joints_).cwiseAbs().maxCoeff();
    for (double& k : z.tail(joints_)) k = 1.0 / std::max(std::abs(k), 1e-3 * largest);
    return z;
  }

 private:
  struct Joint {
    Index known;              // columns that act on it
    MatrixXd torques;         // products of [Y, known]
    VectorXd of_w;            // those times w: of each column with tau
    VectorXd with_current;    // of [Y, known] with the current
    double product, squares;  // of tau with the current, and of itself
  };
  const std::vector<std::size_t>& acts(Index c) const { return data_.base.acts[c]; }
  Joint joint(const std::vector<JointSums>& sums, const VectorXd& z, Index c) const {
    const MatrixXd& p = sums[c].products;
    const Index known = std::ssize(acts(c));
    VectorXd w(known + 1);
    w << z(acts(c)), 1.0;
    Joint j{known, p.topLeftCorner(known + 1, known + 1), {}, p.col(known + 1).head(known + 1), 0.0, 0.0};
    j.of_w = j.torques * w;
    j.product = w.dot(j.with_current);
    j.squares = w.dot(j.of_w);
    return j;
  }

  const DynamicsData& data_;
  Index base_, joints_;
};

/// Levenberg's and Marquardt's steps for fixed weights.
void descendTo(const CurrentFit& fit, const std::vector<JointSums>& sums, const VectorXd& variance, VectorXd& z) {
  constexpr int kSteps = 100;
  constexpr double kSettled = 1e-12;
  const auto cost = [&](const VectorXd& at) { return fit.errors(sums, at).cwiseQuotient(variance).sum(); };
  double now = cost(z), damping = 1e-6;
  for (int step = 0; step < kSteps && damping < 1e8; ++step) {
    stopIfInterrupted();
    const NormalEquations n = fit.normal(sums, z, variance);
    MatrixXd a = n.a;
    for (double& diagonal : a.diagonal()) diagonal = diagonal > 0.0 ? (1.0 + damping) * diagonal : 1.0;
    const VectorXd next = z + a.ldlt().solve(n.b);
    const double there = cost(next);
    if (!(there < now)) {
      damping *= 10.0;
      continue;
    }
    const bool settled = now - there < kSettled * now;
    z = next;
    now = there;
    damping = std::max(0.1 * damping, 1e-10);
    if (settled) return;
  }
}

/// What the bodies found ask of the joints, as a multiple of what those of the file do.
double timesTheFile(const DynamicsData& data, const VectorXd& x, const MatrixXd& products) {
  const VectorXd in_file = baseInFile(data), drawn = products * in_file;
  return x.dot(drawn) / in_file.dot(drawn);
}

}  // namespace

ExtraColumn payloadTorques(const KnownPayload& payload, const RobotLog& log, const RobotRegressor& regressor,
                           const ArmModel& arm) {
  std::vector<std::string> bodies;
  Index column = -1;
  for (std::size_t b = 0; b < regressor.bodies(); ++b) {
    bodies.push_back(arm.bodies[regressor.dynamics().bodies()[b]].name);
    if (bodies.back() == payload.body) column = regressor.bodyColumn(b);
  }
  if (column < 0) {
    throw ConfigError(
        fmt::format("--payload: found the body {}, expected one of {}", payload.body, fmt::join(bodies, ", ")));
  }
  VectorXd p = VectorXd::Zero(regressor.columns());
  MassProperties point;
  point.mass = payload.mass;
  point.centre_of_mass = payload.centre;
  p.segment<kBodyParameters>(column) = parametersOf(point);
  const std::vector<StribeckCurve> no_friction(regressor.coordinates());
  const MatrixXd torques = predictTorques(log, regressor, p, no_friction) -
                           predictTorques(log, regressor, VectorXd::Zero(p.size()), no_friction);
  ExtraColumn known;
  for (Index c = 0; c < torques.cols(); ++c) {
    known.emplace_back(torques.col(c));
    for (std::size_t row = 0; row < log.rows(); ++row) {
      if (!payload.carried[log.session[row]]) known.back()[row] = 0.0;
    }
  }
  return known;
}

std::vector<double> TorqueConstants::values() const {
  std::vector<double> values;
  for (const Estimate& constant : constants) values.push_back(constant.value);
  return values;
}

TorqueConstants findTorqueConstants(const DynamicsData& data, const std::vector<std::string>& joints) {
  constexpr int kPasses = 4;
  const std::vector<bool> all(data.sums.blocks.size(), true);
  const std::vector<JointSums> sums = data.sums.total(all);
  for (std::size_t c = 0; c < joints.size(); ++c) {
    if (sums[c].rows == 0.0) {
      throw DataError(
          fmt::format("joint {} does not move in any row, expected motion of every joint: nothing tells its "
                      "torque constant",
                      joints[c]));
    }
  }
  const CurrentFit fit(data);
  VectorXd z = fit.start(sums), variance(joints.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    const VectorXd errors = fit.errors(sums, z);
    for (std::size_t c = 0; c < joints.size(); ++c) {
      variance[c] = std::max(errors[c], 1e-9 * sums[c].effortSquares()) / std::max(sums[c].rows, 1.0);
    }
    descendTo(fit, sums, variance, z);
  }
  const NormalEquations normal = fit.normal(sums, z, variance);
  const MatrixXd covariance = jackknifeOver(weighedInverse(normal.a), data.sums.blocks.size(), [&](std::size_t b) {
    return fit.normal(data.sums.blocks[b], z, variance);
  });
  const Index base = std::ssize(data.base.columns), n = std::ssize(data.base.acts);
  const double times = timesTheFile(data, z.head(base), normal.a.topLeftCorner(base, base));
  if (!(times > 1.0 / kUnlike && times < kUnlike)) {
    throw DataError(
        fmt::format("by the load the robot's bodies weigh {:.2g} times what its file says, expected {:.2g} "
                    "to {:g}: do these logs carry that load, and is it in kg and m?",
                    times, 1.0 / kUnlike, kUnlike));
  }
  TorqueConstants found;
  const double quantile = studentQuantile(static_cast<double>(data.sums.blocks.size()) - 1.0);
  for (std::size_t c = 0; c < joints.size(); ++c) {
    const Index at = fit.place(static_cast<Index>(c));
    const double k = 1.0 / z[at], sd = k * k * std::sqrt(covariance(at, at));
    if (!(k > 0.0) || !(quantile * sd < kHardly * k)) {
      throw NumericsError(
          fmt::format("the torque constant of {} is not found ({:.3g} ± {:.2g} Nm/A): its joint hardly "
                      "feels the load; carry more of it, further out, or give --torque-constants",
                      joints[c], k, quantile * sd));
    }
    found.constants.push_back(withInterval({joints[c], "Nm_A", k, sd}, quantile * sd));
  }
  // x goes with u as the equations of x alone have it: dx/du = -A_xx^-1 A_xu.
  const MatrixXd slopes = -weighedInverse(normal.a.topLeftCorner(base, base)) * normal.a.topRightCorner(base, n);
  found.base_covariance = slopes * covariance.bottomRightCorner(n, n) * slopes.transpose();
  return found;
}

}  // namespace simgap
