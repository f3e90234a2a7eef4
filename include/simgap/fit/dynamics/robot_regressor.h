/// \file
/// The effort of a robot's joints as a sum of columns times parameters: rigid bodies (inverse_dynamics.h) and what the
/// drive of each joint adds to them,
///
///     tau_j = [Y(q, dq, ddq) pi]_j + J_j ddq_j + sum_t theta_jt x_t(dq_j) + tau_0j,
///
/// the rotor's inertia J as felt at the joint, the terms x_t of a friction law, and an offset. The load of a law that
/// knows one is what bodies and springs ask of the joint, the bodies being those of the arm, or of setLoad: so that the
/// torque stays linear. And which of these columns any motion can tell apart: the base parameters (Gautier & Khalil
/// 1990), by a rank-revealing QR decomposition over random motions (Gautier 1991).
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "simgap/model/arm/inverse_dynamics.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap {

/// v_s [rad/s] and delta of a joint's Stribeck factor; of laws without one they mean nothing.
struct StribeckCurve {
  double v_s = 1.0, delta = 1.0;
};

/// What every coordinate does at a moment, shape (N) each.
struct RobotMotion {
  std::vector<double> position, velocity, acceleration, direction;
};

class RobotRegressor {
 public:
  /// \throws ConfigError: a ball
  RobotRegressor(const ArmModel& model, const FrictionLaw& law);

  const InverseDynamics& dynamics() const { return dynamics_; }
  const FrictionLaw& law() const { return *law_; }
  std::size_t coordinates() const { return dynamics_.joints().size(); }
  std::size_t bodies() const { return dynamics_.bodies().size(); }

  /// \name Columns, P in all: drives' offset and friction, bodies, rotors.
  ///@{
  Eigen::Index columns() const;
  Eigen::Index offsetColumn(std::size_t c) const;
  Eigen::Index frictionColumn(std::size_t c) const { return offsetColumn(c) + 1; }  ///< the first term's
  Eigen::Index bodyColumn(std::size_t b) const;
  Eigen::Index rotorColumn(std::size_t c) const;
  const std::vector<std::string>& names() const { return names_; }  ///< "elbow.offset", "forearm.mc_x"
  const std::vector<std::string>& units() const { return units_; }
  ///@}

  /// A body without mass in the arm's file stands for a second axis of the next one: its columns are 0.
  bool massless(std::size_t b) const { return massless_[b]; }

  /// The bodies whose torque is the load of friction. \param parameters  shape (P)
  void setLoad(const Eigen::VectorXd& parameters);

  struct Workspace {
    InverseDynamics::Workspace motion;
    RegressorMatrix bodies;
    Eigen::VectorXd load;
  };
  Workspace workspace() const;
  /// Shape (N, P). \param curves  shape (N)
  void rows(const RobotMotion& motion, std::span<const StribeckCurve> curves, Workspace& work,
            Eigen::Ref<RegressorMatrix> y) const;

 private:
  InverseDynamics dynamics_;
  const FrictionLaw* law_;
  Eigen::Vector3d gravity_;
  Eigen::VectorXd load_;  ///< shape (10 B)
  std::vector<bool> massless_;
  std::vector<std::string> names_, units_;
};

/// The parameters that motions can tell apart, as combinations of all.
struct BaseParameters {
  std::vector<Eigen::Index> columns;           ///< of the regressor that are kept, shape (K)
  Eigen::MatrixXd combination;                 ///< shape (K, P): base parameters = combination * all parameters
  std::vector<std::string> names;              ///< shape (K): of the kept column
  std::vector<std::string> texts;              ///< shape (K): "forearm.mc_x + 0.5717 wrist_1.m"
  std::vector<std::string> without_effect;     ///< names of columns that no motion shows
  std::vector<std::vector<std::size_t>> acts;  ///< of each coordinate: base parameters that can act on it
};

/// \param model  gives the limits within which random positions lie.
BaseParameters baseParameters(const RobotRegressor& regressor, const ArmModel& model);

}  // namespace simgap
