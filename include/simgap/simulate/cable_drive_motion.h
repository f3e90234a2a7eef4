/// \file
/// A joint that a motor turns through a Bowden cable over time: its equations of motion with friction that holds at
/// rest, what it is told, and how it follows (003 fig. 6).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/measure/motion_commands.h"
#include "simgap/model/actuator/cable_drive.h"

namespace simgap {

/// Motor, cable and joint. Friction acts at the motor and grows with the torque in the cable.
class CableDriveMotion {
 public:
  explicit CableDriveMotion(const CableDrive& drive);
  /// At rest, the cable stretched by what hangs on the joint. \param joint [rad]
  void reset(double joint);
  /// \param current [A] \param external  torque on the joint from outside [N m] \param dt [s]
  void step(double current, double external, double dt);

  double joint() const { return joint_; }                   ///< [rad]
  double motor() const { return motor_; }                   ///< [rad]
  double motorVelocity() const { return motor_velocity_; }  ///< [rad/s], 0 while it sticks
  double jointVelocity() const { return joint_velocity_; }  ///< [rad/s]
  double cableTorque() const;                               ///< on the joint [N m]

 private:
  DriveFeedForward drive_;
  double ratio_, motor_inertia_, stiffness_, damping_, inertia_, weight_, hangs_at_, viscous_;
  double joint_ = 0.0, joint_velocity_ = 0.0, motor_ = 0.0, motor_velocity_ = 0.0;
};

/// Where the joint shall be, or which torque it shall be given, and a torque from outside, over time.
struct CableDriveCommands {
  bool torque = false;       ///< else a position
  MotionCommands over_time;  ///< rows: position [rad] or torque, external torque [N m]
};
/// Columns `position_rad` or `torque_Nm`; `external_torque_Nm` (0). \throws DataError: neither or both, as readCommands
CableDriveCommands readCableDriveCommands(const CsvTable& table, bool linear);
/// The same names under `joint:` of a `simgap/schedule/1`. \param rate  of the controller [Hz]  \throws ConfigError
CableDriveCommands readCableDriveSchedule(const YamlNode& root, double rate);

/// How far the motor wanders while it should rest where the path ends.
struct DriveHunting {
  double seconds = 0.0;    ///< looked at: the second half of that rest; 0: it is too short
  double amplitude = 0.0;  ///< half of what the motor's angle over the ratio goes from end to end [rad]
  double frequency = 0.0;  ///< [Hz], of two reversals a period; 0: it rests, or creeps
  bool found() const { return frequency > 0.0; }
};

/// How well a drive followed, over all ticks. Angles [rad] of the joint; torques [N m] know no trapezoids, motor,
/// cable.
struct DriveTracking {
  double rms = 0.0, largest = 0.0;                  ///< of joint - reference, or of torque in the cable - told
  double motor = 0.0, cable = 0.0;                  ///< RMS of motor / N - reference, of joint - motor / N
  double trajectory = 0.0;                          ///< RMS of reference - told: what set-points and trapezoids cost
  double current_rms = 0.0, current_largest = 0.0;  ///< [A]
  double at_limit = 0.0, sticking = 0.0;            ///< shares of the ticks: current at its limit, motor at rest
  DriveHunting hunting;
};

/// Some ticks of a drive; vectors of shape (rows).
struct DriveTrack {
  std::vector<double> time, told, reference, joint, motor, torque,
      current;  ///< motor: its angle / N [rad]; cable [N m]
};

struct DrivePlay {
  double step = 1e-4;     ///< largest step of the integration [s]
  double settle = 2.0;    ///< under the first command before time begins [s]
  double row_rate = 100;  ///< of the track [Hz]
};

struct DriveRun {
  DriveTrack track;
  DriveTracking tracking;
};

/// \param end  on the commands' clock [s]  \throws NumericsError: it blew up
DriveRun playCableDrive(const CableDrive& drive, const FrictionCompensation& compensation,
                        const CableDriveCommands& commands, double end, const DrivePlay& play);

}  // namespace simgap
