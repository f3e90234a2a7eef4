/// \file
/// The log of a robot: position, velocity and effort of every joint on one clock (docs/formats.md, "Logs").
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/core/csv.h"

namespace simgap {

/// [rad] or [m] A presliding that is less than that of any joint: no log says what friction does after a turn.
inline constexpr double kUntold = 1e-9;

/// A joint whose channels a log has to hold; its place in a list is its number in columns such as q1_rad.
struct LoggedJoint {
  std::string name;
  bool slides = false;
  double lower, upper;  ///< [rad] or [m] that it can reach
  /// Travel [rad] or [m] over which its friction builds up, where that is known: an effort that is logged late hides
  /// it, or looks like it. None: from the log.
  std::optional<double> presliding;
};

/// A joint's channels, shape (rows) each. Lengths and forces of a slide are metres and newtons.
struct RobotJointLog {
  std::string name;
  std::string effort_unit;                   ///< "Nm", "N" or "A"
  std::vector<double> position;              ///< [rad]
  std::vector<double> velocity;              ///< [rad/s], smoothed
  std::vector<double> acceleration;          ///< [rad/s^2]
  std::vector<double> sharper_velocity;      ///< [rad/s], smoothed less: kSharper times the bandwidth
  std::vector<double> sharper_acceleration;  ///< [rad/s^2]
  std::vector<double> effort;                ///< [effort_unit]
  std::vector<double> temperature;           ///< [degC] of its drive; empty: not logged
  std::vector<signed char> direction;        ///< sign of the motion, held through its dead band
  std::vector<bool> moves;                   ///< friction acts against a known direction
  double dead_band = 0.0, bandwidth = 0.0;   ///< [rad/s] of the direction; [Hz] of the smoothing
  bool slides = false;
  bool measured_velocity = false;  ///< otherwise worked out from the position
  std::size_t resting = 0;         ///< rows in which it does not move
  double presliding = 0.0;         ///< [rad] of travel after turns and rests that does not count as motion

  /// [s] Half a period of its bandwidth: so far on either side of a turn, a rest or an end motion is the smoother's.
  double blurred() const { return 0.5 / bandwidth; }
};

struct RobotLog {
  std::string file;
  std::vector<double> time;  ///< [s], shape (rows)
  std::vector<int> session;
  std::vector<std::string> session_names;
  std::vector<RobotJointLog> joints;
  std::vector<bool> usable;           ///< shape (rows): not at an end of a run, where a smoother knows one side only
  std::vector<Block> blocks;          ///< of neighbouring rows, for splits and intervals
  std::vector<std::string> warnings;  ///< sentences about the log, for people
  std::size_t rows() const { return time.size(); }
};

/// The same rows with motion that is smoothed less: what a fit finds otherwise there is no more certain than that.
RobotLog sharperMotion(RobotLog log);

/// Reads of every joint J `J_rad` (or `J_position_rad`, `J.position`, `q1_rad` of the first), the velocity if it is
/// there (`J_velocity_rad_s`, `J.velocity`, `qd1_rad_s`), and `torque_J_Nm` (`J_torque_Nm`, `J.effort`, `torque1_Nm`)
/// or `current_J_A` (`J_current_A`, `current1_A`); of slides in m, m/s and N; `J_temperature_degC` if it is there.
/// Stamps that jitter, spikes and late velocities are put right as in every log of a drive.
/// \throws DataError: no time_s, a joint without position or effort, torques of some joints and currents of others, a
/// position beyond the joint's limits, a session too short to be differentiated.
RobotLog readRobotLog(CsvTable table, std::span<const LoggedJoint> joints);

}  // namespace simgap
