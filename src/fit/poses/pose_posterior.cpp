#include "simgap/fit/poses/pose_posterior.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>

#include "simgap/core/decompositions.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

// A measured spread of n repeats is worth n - 1 degrees of freedom, the stated capture noise this many.
constexpr double kCaptureFreedom = 4.0;
constexpr std::size_t kPosesPerThread = 64;  // some 0.6 ms
constexpr double kNearStop = 3.0;            // capture sd: a joint measured this near its stop may be held by it
constexpr double kSmallestTorque = 1e-4;     // [N m], where neither stiffness nor friction would hold a joint

std::vector<std::string> names(const ParameterSpace& space) {
  std::vector<std::string> names;
  for (const SearchParameter& p : space.parameters()) names.push_back(p.name);
  return names;
}

/// Friction holds a joint anywhere within a ball of radius tau_c: uniform there, the variance of each of n components
/// is tau_c^2 / (n + 2). [(N m)^2]
double frictionVariance(const Joint& joint, const PoseNoise& noise) {
  const double coulomb = noise.joint_friction ? joint.coulomb_friction : 0.0;
  return coulomb * coulomb / (joint.degreesOfFreedom() + 2);
}

/// Variance of the mean of a joint's repeats, per component [rad^2], of a slide [m^2].
double captureVariance(const Pose& pose, std::size_t joint, int components, double capture_sd) {
  // The stated noise counts as nu degrees of freedom, the spread s of n repeats as n - 1 more: (nu sd^2 + (n - 1) s^2)
  // / (nu + n - 1), over n for the mean.
  const double freedom = pose.repeats - 1.0;
  const double spread = pose.spread.empty() ? 0.0 : pose.spread[joint];
  const double variance = (kCaptureFreedom * capture_sd * capture_sd + freedom * spread * spread / components) /
                          (kCaptureFreedom + freedom);
  return variance / pose.repeats;
}

/// H^-1 for torques on an arm whose joints may be coupled: T (T^T H T)^-1 T^T.
Eigen::MatrixXd complianceOf(const Eigen::MatrixXd& hessian, const Eigen::MatrixXd& moves) {
  if (moves.size() == 0) return inverse(hessian);
  Eigen::MatrixXd folded = moves.transpose() * hessian * moves;
  for (Eigen::Index d = 0; d < folded.rows(); ++d) {
    if (moves(d, d) == 0.0) folded(d, d) = 1.0;
  }
  return moves * inverse(folded) * moves.transpose();
}

}  // namespace

double robustLoss(double squared) {
  return kRobustScale * kRobustScale * std::log1p(squared / (kRobustScale * kRobustScale));
}
double robustWeight(double squared) { return 1.0 / (1.0 + squared / (kRobustScale * kRobustScale)); }

double robustConsistency(int n) {
  const boost::math::chi_squared_distribution<double> normal(n);
  const auto weighed = [&](double s) { return s * robustWeight(s) * boost::math::pdf(normal, s); };
  const double far = boost::math::quantile(boost::math::complement(normal, 1e-12));
  return n / boost::math::quadrature::gauss_kronrod<double, 61>::integrate(weighed, 0.0, far, 5, 1e-8);
}

ScaledParameters::ScaledParameters(const ParameterSpace& space) : parameters_(space.parameters()) {
  for (const SearchParameter& p : parameters_) {
    const double sd = p.prior_sd.value_or(p.step);
    logarithmic_.push_back(p.lower > 0.0);
    scale_.push_back(logarithmic_.back() ? sd / p.initial : sd);
  }
}

double ScaledParameters::value(Eigen::Index i, double z) const {
  const auto k = static_cast<std::size_t>(i);
  const SearchParameter& p = parameters_[k];
  const double value = logarithmic_[k] ? p.initial * std::exp(scale_[k] * z) : p.initial + scale_[k] * z;
  return std::clamp(value, p.lower, p.upper);  // rounding must not carry a bound parameter beyond its bound
}

double ScaledParameters::scaled(Eigen::Index i, double value) const {
  const auto k = static_cast<std::size_t>(i);
  const double initial = parameters_[k].initial;
  return (logarithmic_[k] ? std::log(value / initial) : value - initial) / scale_[k];
}

double ScaledParameters::slope(Eigen::Index i, double z) const {
  const auto k = static_cast<std::size_t>(i);
  return logarithmic_[k] ? scale_[k] * value(i, z) : scale_[k];
}

double ScaledParameters::lower(Eigen::Index i) const { return scaled(i, parameters_[i].lower); }
double ScaledParameters::upper(Eigen::Index i) const { return scaled(i, parameters_[i].upper); }

std::vector<double> ScaledParameters::values(const Eigen::VectorXd& z) const {
  std::vector<double> values(scale_.size());
  for (Eigen::Index i = 0; i < size(); ++i) values[i] = value(i, z[i]);
  return values;
}

Eigen::VectorXd ScaledParameters::scaled(std::span<const double> values) const {
  Eigen::VectorXd z(size());
  for (Eigen::Index i = 0; i < size(); ++i) z[i] = scaled(i, values[i]);
  return z;
}

PosePosterior::PosePosterior(const ArmModel& model, std::span<const Pose> poses, const ParameterSpace& space,
                             const PoseNoise& noise)
    : model_(model),
      poses_(poses),
      space_(space),
      scaled_(space),
      noise_(noise),
      static_parameters_(staticParameters(model, names(space))),
      slopes_(Eigen::VectorXd::Zero(scaled_.size())),
      arm_(withoutRopes(model)) {
  const int n = arm_.energy().degreesOfFreedom();
  whitening_.assign(poses.size(), Eigen::MatrixXd::Identity(n, n) / noise.capture_sd);
  stiffness_.assign(poses.size(), Eigen::MatrixXd::Identity(n, n));
  residuals_.resize(poses.size());
  for (PoseResidual& residual : residuals_) {
    residual.error.setZero(n);
    residual.jacobian.setZero(n, scaled_.size());
  }
  whiten(Eigen::VectorXd::Zero(scaled_.size()));
}

PosePosterior::PosePosterior(const PosePosterior& other, std::span<const Pose> poses)
    : PosePosterior(other.model_, poses, other.space_, other.noise_) {}

ArmModel PosePosterior::modelAt(const Eigen::VectorXd& z) const {
  ArmModel model = model_;
  space_.apply(scaled_.values(z), model);
  return model;
}

void PosePosterior::setParameters(const Eigen::VectorXd& z) {
  space_.apply(scaled_.values(z), model_);
  arm_.setModel(model_);
  for (Eigen::Index i = 0; i < z.size(); ++i) slopes_[i] = scaled_.slope(i, z[i]);
}

void PosePosterior::whiten(const Eigen::VectorXd& z) {
  setParameters(z);
  const int n = arm_.energy().degreesOfFreedom();
  PotentialEnergy energy(model_);
  const Eigen::MatrixXd moves = couplingsOf(energy);
  Eigen::VectorXd friction(n), capture(n);
  for (std::size_t p = 0; p < poses_.size(); ++p) {
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      const int components = joint.degreesOfFreedom();
      friction.segment(energy.firstDof(static_cast<int>(j)), components).setConstant(frictionVariance(joint, noise_));
      capture.segment(energy.firstDof(static_cast<int>(j)), components)
          .setConstant(captureVariance(poses_[p], j, components, noise_.sdOf(joint.type)));
    }
    energy.setHistory(poses_[p].time, poses_[p].shafts_before);
    energy.setShafts(poses_[p].shafts);
    energy.evaluate(poses_[p].joints);
    stiffness_[p] = energy.hessian();
    // A torque tau moves the equilibrium by H^-1 tau: cov = C + H^-1 T H^-1 = L L^T, whitened by L^-1.
    const Eigen::MatrixXd compliance = complianceOf(energy.hessian(), moves);
    const Eigen::MatrixXd covariance =
        Eigen::MatrixXd(capture.asDiagonal()) + compliance * friction.asDiagonal() * compliance.transpose();
    whitening_[p] = covariance.llt().matrixL().solve(Eigen::MatrixXd::Identity(n, n));
  }
}

void PosePosterior::whitenLike(const PosePosterior& other) {
  whitening_ = other.whitening_;
  stiffness_ = other.stiffness_;
}

const std::vector<PoseResidual>& PosePosterior::evaluate(const Eigen::VectorXd& z, bool jacobians) {
  setParameters(z);
  if (poses_.size() < 2 * kPosesPerThread) {
    for (std::size_t p = 0; p < poses_.size(); ++p) evaluatePose(arm_, p, jacobians);
    return residuals_;
  }
  tbb::enumerable_thread_specific<EquilibriumArm> arms(arm_);
  const tbb::blocked_range<std::size_t> all(0, poses_.size(), kPosesPerThread);
  const auto some = [&](const tbb::blocked_range<std::size_t>& range) {
    EquilibriumArm& arm = arms.local();
    for (std::size_t p = range.begin(); p < range.end(); ++p) evaluatePose(arm, p, jacobians);
  };
  // Isolated: a thread that waits here must not begin with another start of the same search.
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(all, some, tbb::simple_partitioner()); });
  return residuals_;
}

void PosePosterior::evaluatePose(EquilibriumArm& arm, std::size_t p, bool jacobian) {
  const Pose& pose = poses_[p];
  PoseResidual& residual = residuals_[p];
  arm.setHistory(pose.time, pose.shafts_before);
  // Most poses are near the measured one. Where no way leads down from there, the arm comes from its rest, as it did.
  residual.valid = arm.solveFrom(pose.joints, pose.shafts).stable || arm.solve(pose.shafts).stable;
  if (!residual.valid) return;
  const std::vector<JointPosition>& observed = arm.observe(pose.shafts, pose.shafts_before);
  if (jacobian) {
    arm.linearise();
    // dq/dtheta = -H^-1 d2V/dq dtheta, as the rig sees it; dtheta/dz from the scales.
    arm.observedSensitivities(static_parameters_, residual.jacobian);
    for (Eigen::Index i = 0; i < slopes_.size(); ++i) residual.jacobian.col(i) *= slopes_[i];
  }
  measureError(pose, observed, residual, jacobian);
  // L^-1 e and L^-1 J: independent errors of variance 1.
  residual.error = whitening_[p] * residual.error;
  if (jacobian) residual.jacobian = whitening_[p] * residual.jacobian;
}

void PosePosterior::measureError(const Pose& pose, const std::vector<JointPosition>& observed, PoseResidual& residual,
                                 bool jacobian) const {
  for (std::size_t j = 0; j < model_.joints.size(); ++j) {
    const int d = arm_.energy().firstDof(static_cast<int>(j));
    const JointPosition& simulated = observed[j];
    if (model_.joints[j].hasAxis()) {
      residual.error[d] = simulated.angle - pose.joints[j].angle;
      continue;
    }
    // e = log(q_measured^-1 q), and de = J_r(e)^-1 dw when q goes to q exp(dw).
    const Eigen::Vector3d error = logSo3(pose.joints[j].rotation.conjugate() * simulated.rotation);
    residual.error.segment<3>(d) = error;
    if (jacobian) residual.jacobian.middleRows<3>(d) = inverseRightJacobian(error) * residual.jacobian.middleRows<3>(d);
  }
}

const std::vector<PoseResidual>& PosePosterior::evaluateTorques(const Eigen::VectorXd& z, double sd) {
  setParameters(z);
  PotentialEnergy energy(model_);
  const Eigen::MatrixXd moves = couplingsOf(energy);
  for (std::size_t p = 0; p < poses_.size(); ++p) {
    PoseResidual& residual = residuals_[p];
    energy.setHistory(poses_[p].time, poses_[p].shafts_before);
    energy.setShafts(poses_[p].shafts);
    energy.evaluate(poses_[p].joints);
    energy.differentiate(static_parameters_, residual.jacobian);
    for (Eigen::Index i = 0; i < slopes_.size(); ++i) residual.jacobian.col(i) *= slopes_[i];
    // At the measured joints the torque dV/dq should vanish. A capture error of sd moves it by H sd, friction holds
    // torques within its ball: cov = sd^2 H H^T + tau_c^2 / (n + 2).
    residual.error = energy.gradient();
    Eigen::MatrixXd moved = stiffness_[p];  // torques of a capture error
    if (moves.size() > 0) {
      residual.error = moves.transpose() * residual.error;
      residual.jacobian = moves.transpose() * residual.jacobian;
      moved = moves.transpose() * moved * moves;
    }
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      if (model_.joints[j].slides()) moved.col(energy.firstDof(static_cast<int>(j))) *= kSlideLever;
    }
    Eigen::MatrixXd covariance = sd * sd * moved * moved.transpose();
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      const int components = joint.degreesOfFreedom();
      const int d = energy.firstDof(static_cast<int>(j));
      covariance.diagonal().segment(d, components).array() +=
          frictionVariance(joint, noise_) + kSmallestTorque * kSmallestTorque;
      const double angle = poses_[p].joints[j].angle;
      const double near = kNearStop * noise_.sdOf(joint.type);
      if (joint.hasAxis() && ((angle < joint.lower_limit + near && residual.error[d] > 0.0) ||
                              (angle > joint.upper_limit - near && residual.error[d] < 0.0))) {
        residual.error[d] = 0.0;  // the stop holds it
        residual.jacobian.row(d).setZero();
      }
    }
    const auto factor = covariance.llt();
    residual.valid = true;
    factor.matrixL().solveInPlace(residual.error);
    factor.matrixL().solveInPlace(residual.jacobian);
  }
  return residuals_;
}

double PosePosterior::objective(const Eigen::VectorXd& z) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < z.size(); ++i) sum += scaled_.hasPrior(i) ? z[i] * z[i] : 0.0;
  for (const PoseResidual& residual : evaluate(z, false)) {
    if (!residual.valid) return std::numeric_limits<double>::infinity();
    sum += robustLoss(residual.error.squaredNorm());
  }
  return 0.5 * sum;
}

}  // namespace simgap
