/// \file
/// Robots of hinges and slides, and what their controllers log of a motion. The torques are those of Lagrange's
/// equations in world coordinates,
///
///     tau = M ddq + (dM/dt) dq - d/dq (dq^T M dq / 2) - sum_k m_k J_k^T g + J_rotor ddq + friction + offset,
///
/// with M from the Jacobians of all bodies and its derivatives by central differences: no recursion, no regressor.
/// Friction falls with speed from a static to a kinetic level (a Lorentzian, no exponential); at rest it is whatever
/// the controller has left within the static level.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace simgap::reality {

struct RobotLink {
  int parent = -1;  ///< -1: the base
  bool slides = false;
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  ///< of the joint, in the parent
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double lower = -2.5, upper = 2.5;                   ///< [rad] or [m]
  double mass = 1.0;                                  ///< [kg]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< [m] in the link
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< [kg m^2] about the centre
  double rotor = 0.0, coulomb = 0.0, viscous = 0.0, offset = 0.0;
  double more_static = 0.0, stribeck_speed = 0.1;  ///< static above kinetic friction [N m], [rad/s]
  /// \name What a model of rigid bodies and plain drives lacks; nothing unless robot_flaws.h puts it there
  ///@{
  double viscous_power = 1.0, top_speed = 1.0;  ///< viscous |v / top|^(power - 1) v
  double viscous_forwards = 0.0;                ///< more of it forwards, as much less backwards [N m s/rad]
  double load_friction = 0.0;                   ///< of what the bodies ask of the joint [1]
  int coupled_to = -1;                          ///< a link whose joint's load
  double coupled_friction = 0.0;                ///< adds to the friction [1]
  double spring = 0.0, spring_rest = 0.0;       ///< [N m/rad], [rad]
  double ripple = 0.0, ripple_ratio = 1.0, ripple_phase = 0.0;  ///< [N m], periods a turn, [rad]
  double bias = 0.0;                                            ///< of the logged effort [N m]
  double effort_gain = 1.0;                                     ///< logged torque per true torque
  double zero = 0.0;                                            ///< true position less the logged one [rad]
  /// [s] of the effort; of position and velocity; of all that is logged of the joint
  double effort_late = 0.0, position_late = 0.0, clock_late = 0.0;
  double gives = 0.0;  ///< of the gear behind an encoder at the motor [rad/(N m)]
  /// Share of its friction that goes as the drive warms up by moving [1]; its temperature is logged then.
  double thins = 0.0;
  ///@}
};

/// A point mass that the last link carries for a while.
struct RobotLoad {
  double mass = 0.0;                             ///< [kg]
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< [m] in the link
  double from = 0.0, until = 0.0;                ///< [s] since the log begins
};

/// Pulls the last link's centre to a place: no cause of the catalogue.
struct RobotCord {
  double stiffness = 0.0;                    ///< [N/m]
  Eigen::Vector3d anchor = {0.5, 0.4, 1.2};  ///< [m]
};

struct Robot {
  std::vector<RobotLink> links;
  Eigen::Vector3d gravity = {0.0, 0.0, -9.81};
  RobotLoad load = {};
  RobotCord cord = {};
};

/// A point mass on a link, for good: by Huygens and Steiner about the common centre.
void hang(RobotLink& link, double mass, const Eigen::Vector3d& point);

/// Bodies, rotors and friction of a robot of that many joints; a chain, or a tree. A quarter of the joints slide where
/// `slides` is set.
Robot randomRobot(std::uint64_t seed, int joints, bool tree, bool slides);

/// Torques for a motion, without friction, rotors and offsets; shape (links).
Eigen::VectorXd rigidTorques(const Robot& robot, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                             const Eigen::VectorXd& a);

struct RobotRigOptions {
  double duration = 60.0, rate = 100.0;  ///< [s], [Hz]
  double period = 20.0;                  ///< [s] of the Fourier series
  int harmonics = 5;
  double top_speed = 1.5;          ///< [rad/s], slides a fifth of it [m/s]
  double position_quantum = 2e-5;  ///< [rad], slides a fifth of it [m]
  double torque_noise = 0.02;      ///< of a joint's usual torque
  double correlation = 0.5;        ///< of the noise in a row and the next
  bool stops = true;               ///< joints stand still for a while, each at times of its own
  bool log_velocity = false;
  double velocity_noise = 0.002;  ///< [rad/s] or [m/s]
  double tracking_error = 0.0;    ///< [rad] or [m] by which friction holds a joint back from its course
  double loop = 40.0;             ///< [rad/s] of the controllers that hold it on its course
  bool current = false;           ///< currents of the constants below instead of torques
  double start = 0.0;             ///< [s] where in the series the log begins
};

/// CSV: time_s; of joint k, j1 on, jK_rad, torque_jK_Nm or current_jK_A, and with `log_velocity` jK_velocity_rad_s;
/// of a joint whose friction thins jK_temperature_degC.
/// \param draw  numbers motion and noise. \param constants  shape (links) [N m/A]
std::string recordRobot(const Robot& robot, const RobotRigOptions& options, std::uint64_t draw,
                        const std::vector<double>& constants = {});

/// The torques that the log holds, before noise, shape (rows, links).
Eigen::MatrixXd loggedTorques(const Robot& robot, const RobotRigOptions& options, std::uint64_t draw);

/// The robot as somebody has drawn it: masses off by a factor of exp(0.2 z), inertias by exp(0.3 z), centres by 2 cm.
/// No friction, no rotors. \param draw  of the errors; 0: none
std::string drawnUrdf(const Robot& robot, std::uint64_t draw);

}  // namespace simgap::reality
