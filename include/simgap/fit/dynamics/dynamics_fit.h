/// \file
/// Rigid bodies and drives of a robot from its log, all joints at once. Base parameters are what the log says alone, by
/// least squares over all joints, each weighed by its noise; their intervals come from a jackknife over blocks of time,
/// which holds for residuals that are alike over rows and joints. The model is what the log and the robot's file say
/// together: bodies that can exist (pseudo_inertia.h), with the file's as priors, rotors and friction not below 0.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "simgap/fit/dynamics/dynamics_sums.h"
#include "simgap/fit/dynamics/pseudo_inertia.h"
#include "simgap/optimize/parameter.h"

namespace simgap {

/// Everything a fit works on. The regressor and its base belong to the robot, the sums to its log.
struct DynamicsData {
  const ArmModel& arm;
  const RobotRegressor& regressor;
  const BaseParameters& base;
  const DynamicsSums& sums;
};

struct BaseEstimate {
  Estimate estimate;     ///< of the log alone
  std::string text;      ///< the combination
  double in_file = 0.0;  ///< of the bodies in the robot's file, without friction and rotors
  double in_model = 0.0;
};

/// Parameters of all columns, and what they were found with.
struct DynamicsModel {
  Eigen::VectorXd parameters;            ///< shape (P), of bodies that can exist
  std::vector<double> torque_constants;  ///< shape (N) [N m/A]; 1 where the log holds torques
};

struct DynamicsFit {
  DynamicsModel model;
  Eigen::VectorXd sd;               ///< shape (P): of the parameters, given the priors
  Eigen::VectorXd prior_sd;         ///< shape (P): of the priors alone, 0 without one
  Eigen::MatrixXd base_covariance;  ///< shape (K, K): of the model's base parameters
  std::vector<BaseEstimate> base;
  std::vector<double> noise;  ///< shape (N): deviation of the residual in the log's unit
  std::vector<double> rows;   ///< shape (N): rows that count
  double inflation = 1.0;     ///< variance of the estimates, of that for independent residuals
  std::vector<double> error;  ///< shape (N): relative, on the rows that were fitted
  bool converged = true;
};

/// Errors of each joint, shape (N), on blocks that the model was not fitted to: relative, |k i - tau| / |k i|.
struct HeldOutErrors {
  std::vector<double> alone;  ///< a joint with its own friction and offset only
  std::vector<double> model;
  std::vector<double> sd;  ///< the model's in the log's unit; 0 of a joint that never moves
};

/// \param torque_constants  shape (N) [N m/A]; 1 where the log holds torques
DynamicsFit fitDynamics(const DynamicsData& data, const std::vector<double>& torque_constants);

/// Parameters of bodies that can exist, of some blocks, shape (P). \param used  shape (blocks)
Eigen::VectorXd fittedParameters(const DynamicsData& data, const std::vector<double>& torque_constants,
                                 const std::vector<bool>& used);

/// The sums that a fit to some blocks works on: where a law is not linear in all it has, its curves are chosen by those
/// blocks alone. \param fitted  shape (blocks)
using SumsOfFold = std::function<std::shared_ptr<const DynamicsSums>(const std::vector<bool>& fitted)>;

/// \param fold  shape (blocks): each fold is predicted by a fit to the others.
HeldOutErrors crossValidate(const ArmModel& arm, const RobotRegressor& regressor, const BaseParameters& base,
                            const SumsOfFold& sums_of, const std::vector<double>& torque_constants,
                            const std::vector<int>& fold);

/// The bodies of the arm with other inertial parameters, and its joints with the friction that an arm file knows.
ArmModel armWith(const ArmModel& arm, const RobotRegressor& regressor, const Eigen::VectorXd& parameters);

}  // namespace simgap
