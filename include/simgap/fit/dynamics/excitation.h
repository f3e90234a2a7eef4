/// \file
/// The motion from which a robot's bodies and drives are learned best: every joint follows a finite Fourier series,
///
///     dq_j(t) = sum_k a_jk cos(k w t) + b_jk sin(k w t),   w = 2 pi / duration,
///
/// which is periodic, of a known bandwidth, and here begins and ends at rest (Swevers et al. 1997: "Optimal Robot
/// Excitation and Identification"). Its numbers are searched by CMA-ES within the limits, so that what is asked for is
/// expected to be known best.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "simgap/core/units.h"
#include "simgap/core/yaml.h"
#include "simgap/fit/dynamics/robot_regressor.h"

namespace simgap {

/// What a joint may do, in [rad], [N m] or [m], [N].
struct JointExcitationLimits {
  double lower, upper;
  double velocity, acceleration;
  double effort = kInfinity;  ///< by the bodies and frictions of the robot's file
  double noise = 1.0;         ///< of its measured effort, deviation per row; only ratios between joints matter
};

/// A point of a body keeps away from a point of another, or from a plane of the base.
struct DistanceLimit {
  int body = 0;  ///< of the arm
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  int other = -1;  ///< -1: a plane
  Eigen::Vector3d other_point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of the plane, unit length
  double plane = 0.0;                                 ///< [m] of it along the normal
  double least = 0.0;                                 ///< [m]
  std::string name;                                   ///< "tool over a plane"
};

/// `simgap/excitation-limits/1` (docs/formats.md).
struct ExcitationLimits {
  double duration = 10.0;  ///< [s] of a period
  int periods = 1;
  double rate = 100.0;  ///< [Hz] of the trajectory's rows
  int harmonics = 5;
  std::string payload;                        ///< a body whose load is asked for; empty: all base parameters
  std::vector<JointExcitationLimits> joints;  ///< shape (N)
  std::vector<DistanceLimit> distances;

  /// \throws ConfigError: an unknown joint or body, no speed for a joint, limits that contradict each other
  static ExcitationLimits read(const YamlNode& root, const ArmModel& arm);
};

/// Positions, velocities and accelerations of a series at a moment, shape (N) each.
class FourierMotion {
 public:
  FourierMotion() = default;  ///< of no joint
  /// \param a, b  shape (N, harmonics) of the velocity [rad/s]  \param start  shape (N) where it begins and ends
  FourierMotion(double duration, Eigen::MatrixXd a, Eigen::MatrixXd b, Eigen::VectorXd start);
  void at(double time, RobotMotion& motion) const;
  double duration() const { return duration_; }
  const Eigen::MatrixXd& cosines() const { return a_; }
  const Eigen::MatrixXd& sines() const { return b_; }
  const Eigen::VectorXd& start() const { return start_; }

 private:
  double duration_ = 0.0;
  Eigen::MatrixXd a_, b_;
  Eigen::VectorXd start_;
};

/// What a motion is worth.
struct ExcitationPrecision {
  Eigen::VectorXd sd;      ///< expected, shape (K) of base parameters, or (4) of a payload: m, m c_x, m c_y, m c_z
  double log_sd = 0.0;     ///< mean logarithm over all directions: what is minimised
  double condition = 0.0;  ///< of the information, its columns scaled to length 1
};

/// Furthest that a joint goes.
struct JointExcursion {
  double lower, upper, velocity, acceleration, effort;
};

struct Excitation {
  FourierMotion motion;
  ExcitationPrecision precision;
  int random_drawn = 0;                     ///< series at random
  std::vector<FourierMotion> drawn;         ///< of those the ones that keep the limits
  std::vector<ExcitationPrecision> random;  ///< and what they are worth
  std::vector<JointExcursion> reached;      ///< shape (N), over the rows
  std::vector<double> nearest;              ///< shape (distances) [m]
  std::vector<std::string> names, units;    ///< of `precision.sd`
};

/// \param news  called with the share done; \throws ConfigError: a payload or limits that leave no motion;
/// InterruptedError
Excitation exciteRobot(const ArmModel& arm, const FrictionLaw& law, const ExcitationLimits& limits, std::uint64_t seed,
                       const std::function<void(double share)>& news);

}  // namespace simgap
