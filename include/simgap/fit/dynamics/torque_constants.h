/// \file
/// What a robot's motors give per ampere, from currents alone: currents tell constants and masses only as products, but
/// logs with and without a known load differ by torques that are known (Gautier & Briot 2014: "Global Identification of
/// Joint Drive Gains and Dynamic Parameters of Robots"). With base parameters x and constants k
///
///     i_j = ([Y x]_j + springs_j + load_j) / k_j + noise,
///
/// least squares of the currents: of k i - tau they would shrink k, as the noise of i stands beside k there.
#pragma once

#include <string>
#include <vector>

#include "simgap/fit/dynamics/dynamics_fit.h"

namespace simgap {

/// A mass, taken as a point, that a body carries in some sessions of a log.
struct KnownPayload {
  std::string body;
  double mass = 0.0;                                 ///< [kg]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< [m] in the body's frame
  std::vector<bool> carried;                         ///< shape (sessions)
};

/// Its torques, shape (N)(rows); 0 where it is not carried. \throws ConfigError: no body of the robot that moves
ExtraColumn payloadTorques(const KnownPayload& payload, const RobotLog& log, const RobotRegressor& regressor,
                           const ArmModel& arm);

struct TorqueConstants {
  std::vector<Estimate> constants;  ///< shape (N) [N m/A] or [N/A]
  /// Shape (K, K): what their uncertainty adds to the covariance of the base parameters, which others give for known
  /// constants.
  Eigen::MatrixXd base_covariance;

  std::vector<double> values() const;
};

/// \param data  of logs with and without the load, whose torques are among the known ones of the sums
/// \param joints  names, shape (N)
/// \throws DataError: a joint that never moves, or a load that makes bodies of quite other masses than the file's;
/// NumericsError: a joint that hardly feels it
TorqueConstants findTorqueConstants(const DynamicsData& data, const std::vector<std::string>& joints);

}  // namespace simgap
