/// \file
/// What recorded poses and hand measurements together say of an arm's parameters: the negative log posterior
///
///   1/2 sum_p rho(d_p^2) + 1/2 |z|^2,    d_p^2 = e_p^T S_p^-1 e_p,    rho(s) = c^2 log(1 + s / c^2),  c^2 = 36
///
/// e_p: distance of the simulated from the measured pose in the joints' tangent space (spherical: the rotation vector
/// of q_measured^-1 q, in the child's frame). z: the parameters in standard deviations of their hand measurement, those
/// that are positive by nature on a log scale. The heavy tail of rho lets a flipped or stuck pose go.
///
/// A joint with Coulomb friction may stop beside its equilibrium by as much as the friction holds, so
///
///   S_p = S_capture + H^-1 S_tau H^-1,    S_tau = tau_C^2 / (n + 2) for the n components of the joint: uniform in what
///   the friction holds,
///
/// with the Hessian H of the potential energy at the measured pose.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "simgap/fit/poses/pose_noise.h"
#include "simgap/measure/pose_set.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {

/// With fewer recorded poses a fit says nothing about others.
inline constexpr std::size_t kFewestPoses = 8;

/// Parameters as a fit sees them, z = 0: the model as it was measured by hand.
class ScaledParameters {
 public:
  explicit ScaledParameters(const ParameterSpace& space);
  Eigen::Index size() const { return static_cast<Eigen::Index>(scale_.size()); }
  double value(Eigen::Index i, double z) const;       ///< in the parameter's unit
  double scaled(Eigen::Index i, double value) const;  ///< its inverse
  double slope(Eigen::Index i, double z) const;       ///< d value / d z
  double lower(Eigen::Index i) const;                 ///< bounds of z, may be infinite
  double upper(Eigen::Index i) const;
  bool hasPrior(Eigen::Index i) const { return parameters_[i].prior_sd.has_value(); }
  std::vector<double> values(const Eigen::VectorXd& z) const;
  Eigen::VectorXd scaled(std::span<const double> values) const;

 private:
  std::vector<SearchParameter> parameters_;
  std::vector<double> scale_;  ///< standard deviation of the prior, or the search's initial step without one
  std::vector<bool> logarithmic_;
};

/// How the simulated pose differs from the measured one, and how that depends on z.
struct PoseResidual {
  bool valid = false;
  Eigen::VectorXd error;     ///< shape (dof), whitened: |error|^2 is d_p^2
  Eigen::MatrixXd jacobian;  ///< shape (dof, parameters)
};

inline constexpr double kRobustScale = 6.0;  ///< c: poses beyond some 6 sd count ever less

/// rho(s) and its derivative, the weight of a pose.
double robustLoss(double squared);
double robustWeight(double squared);

/// n / E[s rho'(s)], s ~ chi^2_n: times the loss, errors that are normal tell their own size.
double robustConsistency(int n);

class PosePosterior {
 public:
  /// \param poses  must outlive it.
  PosePosterior(const ArmModel& model, std::span<const Pose> poses, const ParameterSpace& space,
                const PoseNoise& noise);

  /// The same model, parameters and noise with other poses, whitened at z = 0 until whiten() is called.
  PosePosterior(const PosePosterior& other, std::span<const Pose> poses);

  const ScaledParameters& parameters() const { return scaled_; }
  const ArmModel& model() const { return model_; }
  ArmModel modelAt(const Eigen::VectorXd& z) const;
  const Eigen::MatrixXd& whitening(std::size_t pose) const { return whitening_[pose]; }
  std::span<const Pose> poses() const { return poses_; }
  int degreesOfFreedom() const { return arm_.energy().degreesOfFreedom(); }

  /// Whitens with the Hessians of the model at z. Objectives compare only under one whitening.
  void whiten(const Eigen::VectorXd& z);
  /// Takes over the whitening of another posterior of the same poses.
  void whitenLike(const PosePosterior& other);
  /// Residuals of all poses, shape (poses); equilibria are searched from the measured poses, and from the arm's rest
  /// where that finds none. Of many poses on several threads.
  const std::vector<PoseResidual>& evaluate(const Eigen::VectorXd& z, bool jacobians);
  /// The same for the torques at the measured poses, which should vanish: no equilibrium is searched. A torque counts
  /// by how far it would move the joints, in units of `sd` [rad]; whiten() again sets the stiffness for that.
  const std::vector<PoseResidual>& evaluateTorques(const Eigen::VectorXd& z, double sd);
  /// The negative log posterior; infinite when a pose has no stable equilibrium.
  double objective(const Eigen::VectorXd& z);

 private:
  void setParameters(const Eigen::VectorXd& z);
  void evaluatePose(EquilibriumArm& arm, std::size_t p, bool jacobian);
  void measureError(const Pose& pose, const std::vector<JointPosition>& observed, PoseResidual& residual,
                    bool jacobian) const;

  ArmModel model_;
  std::span<const Pose> poses_;
  ParameterSpace space_;
  ScaledParameters scaled_;
  PoseNoise noise_;
  std::vector<StaticParameter> static_parameters_;
  Eigen::VectorXd slopes_;  ///< of the parameters' values by z, where it was set last, shape (parameters)
  EquilibriumArm arm_;
  std::vector<Eigen::MatrixXd> whitening_;  ///< shape (poses) of (dof, dof): S_p^-1 = W^T W
  std::vector<Eigen::MatrixXd> stiffness_;  ///< shape (poses) of (dof, dof): H where whiten() was called
  std::vector<PoseResidual> residuals_;
};

}  // namespace simgap
