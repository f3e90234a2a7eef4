/// \file
/// A robot's log beside what its model says of every row: what the causes make their columns of.
#pragma once

#include <functional>
#include <vector>

#include "simgap/fit/dynamics/dynamics_sums.h"
#include "simgap/fit/dynamics/robot_model.h"
#include "simgap/measure/logs/actuator_rows.h"

namespace simgap {

/// Everything a cause may ask. Torques are [N m] or [N]; N joints.
class RobotRows {
 public:
  /// \param parameters  shape (P) of the regressor. \param flat  the same of a fit to this log alone, whose residual
  /// shows where to look for what no such numbers explain. \param training  shape (rows): in others the residual is 0
  RobotRows(const RobotLog& log, const RobotModel& model, const RobotRegressor& regressor, Eigen::VectorXd parameters,
            const Eigen::VectorXd& flat, const std::vector<bool>& training);

  const RobotLog& log() const { return log_; }
  const RobotModel& model() const { return model_; }
  const RobotRegressor& regressor() const { return regressor_; }
  const Eigen::VectorXd& parameters() const { return parameters_; }
  std::size_t joints() const { return log_.joints.size(); }
  double constant(std::size_t c) const { return model_.currents ? model_.torque_constants[c] : 1.0; }
  const Joint& joint(std::size_t c) const { return model_.arm.joints[regressor_.dynamics().joints()[c]]; }
  const std::string& jointName(std::size_t c) const { return log_.joints[c].name; }
  const std::string& bodyName(std::size_t b) const { return model_.arm.bodies[regressor_.dynamics().bodies()[b]].name; }
  /// Whether a row counts for a joint.
  bool counts(std::size_t row, std::size_t c) const { return log_.usable[row] && log_.joints[c].moves[row]; }

  const Eigen::MatrixXd& torque() const { return torque_; }  ///< of the model, shape (rows, N)
  /// What a change of the parameters asks more, shape (rows, N). \param change  shape (P)
  Eigen::MatrixXd torqueOf(const Eigen::VectorXd& change) const;
  const Eigen::MatrixXd& rigid() const { return rigid_; }  ///< of its bodies and springs alone
  /// A joint as the log of a drive: its load is what the bodies ask of it, its effort in [N m].
  const ActuatorRows& drive(std::size_t c) const { return drives_[c]; }
  /// Measured less what a fit to this log says in training rows that count, 0 in others, shape (rows).
  Eigen::ArrayXd residual(std::size_t c) const;
  /// [s] a tenth of the period of the bandwidth to which the joint's motion was smoothed: what smoothing takes off an
  /// acceleration beside a turn, a shorter delay puts back.
  double shortestDelay(std::size_t c) const { return 0.1 / log_.joints[c].bandwidth; }
  double coulomb(std::size_t c) const;
  double viscous(std::size_t c) const;

  /// What the bodies ask more of every joint where rows of the motion are changed.
  using Change = std::function<void(std::size_t row, RobotMotion& motion, Eigen::Vector3d& gravity)>;
  Eigen::MatrixXd rigidChange(const Change& change) const;
  /// A joint's motion `later` seconds after a row, into that joint of `motion`; a session's ends are held.
  void motionAfter(std::size_t joint, std::size_t row, double later, RobotMotion& motion) const;
  /// Values `later` seconds after each row.
  Eigen::ArrayXd shifted(const Eigen::Ref<const Eigen::ArrayXd>& values, double later) const;

 private:
  /// Rows and weights between which a moment lies.
  std::pair<std::size_t, double> momentAfter(std::size_t row, double later) const;

  const RobotLog& log_;
  const RobotModel& model_;
  const RobotRegressor& regressor_;
  Eigen::VectorXd parameters_;
  std::vector<bool> training_;
  Eigen::MatrixXd torque_, rigid_, flat_torque_;
  Eigen::MatrixXd of_springs_;  ///< torque without any of the parameters
  std::vector<ActuatorRows> drives_;
};

}  // namespace simgap
