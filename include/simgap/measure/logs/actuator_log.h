/// \file
/// Logs of one actuator as columns in SI (docs/formats.md, "Logs"). Channels a log lacks stay empty.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/measure/logs/spikes.h"

namespace simgap {

/// What a drive was commanded or drew, what moved and what loaded it. Every vector has shape (rows), or is empty when
/// the log has no such channel. Angles and torques of a linear axis are metres and newtons.
struct ActuatorLog {
  std::string file;
  std::string effort_name;           ///< column the effort was read from, "motor_current"
  std::string effort_unit;           ///< "A", "V", "Nm" or "N"
  bool linear = false;               ///< a linear axis: m and N instead of rad and N m
  std::vector<double> time;          ///< [s]; row / ActuatorLogOptions::row_rate when the log has none
  std::vector<double> effort;        ///< [effort_unit] what the motor drew
  std::vector<double> velocity;      ///< [rad/s] of the motor
  std::vector<double> position;      ///< [rad] of the motor
  std::vector<double> acceleration;  ///< [rad/s^2] of the motor; never read, derived where a fit needs it
  std::vector<double> load;          ///< [N m] external torque the drive works against
  std::vector<int> session;          ///< label of the row's session, counted from 0 in order of appearance
  std::vector<std::string> session_names;
  bool has_time = false;

  std::size_t rows() const { return effort.size(); }
  /// "rad" or "m", "rad_s" or "m_s", "Nm" or "N".
  const char* angleUnit() const { return linear ? "m" : "rad"; }
  const char* velocityUnit() const { return linear ? "m_s" : "rad_s"; }
  const char* loadUnit() const { return linear ? "N" : "Nm"; }
};

struct ActuatorLogOptions {
  double ratio = 0.0;      ///< motor per joint: multiplies joint channels; 0 when the log must have motor channels
  double row_rate = 50.0;  ///< [Hz] of a log without time, for blocks only
};

/// Reads an actuator log: effort (`motor_current_A`, `motor_voltage_V`, `motor_torque_Nm`, `motor_force_N`), and what
/// there is of `motor_velocity`, `velocity` or `joint_velocity`, the positions of the same names, `external_torque_Nm`
/// or `external_force_N`, `time_s` and `session`.
/// \throws DataError: no effort, neither velocity nor position, joint channels without a ratio, time that does not
///         rise within a session, and all that CsvTable refuses.
ActuatorLog readActuatorLog(CsvTable table, const ActuatorLogOptions& options);

/// A motor or gearbox log. Velocity is the motor's.
struct MotorLog {
  std::string file;
  std::vector<double> time;      ///< [s]
  std::vector<double> voltage;   ///< [V]
  std::vector<double> current;   ///< [A]
  std::vector<double> velocity;  ///< [rad/s]
  std::vector<double> load;      ///< [N m]
  std::vector<int> session;
  std::vector<std::string> session_names;
  std::size_t rows() const { return time.size(); }
};
/// Every channel but time is optional here; the fits say which they need.
/// \throws DataError as readActuatorLog.
MotorLog readMotorLog(CsvTable table);

/// A pneumatic muscle's log.
struct PamLog {
  std::string file;
  std::vector<double> pressure;            ///< [Pa] gauge
  std::vector<double> contraction;         ///< [1] apparent: of the muscle with its tendon
  std::vector<double> force;               ///< [N]; of two muscles the difference
  std::string force_column = "force_N";    ///< that it was read from, or a torque over the pulley's radius
  bool of_joint = false;                   ///< contractions follow from its angle
  double rest = 0.0, opposing_rest = 0.0;  ///< contractions at angle 0, of a joint's muscles
  std::vector<double> time;                ///< [s]
  std::vector<int> session;
  std::vector<std::string> session_names;
  /// Of a muscle that pulls the other way, which is like this one; empty where there is none.
  std::vector<double> opposing_pressure, opposing_contraction;
  std::vector<ChannelSpikes> spikes;  ///< samples that stood alone, where repairSpikes put them right
  std::size_t rows() const { return force.size(); }
  bool opposed() const { return !opposing_pressure.empty(); }
};
PamLog readPamLog(CsvTable table);

/// Of a log over time, not of levels: of levels none stands alone.
void repairSpikes(PamLog& log);

/// What turns a joint's angle into the contraction of the muscles on its pulley (002 section III).
struct MusclePulley {
  double radius = 0.0;         ///< r0 [m]
  double length = 0.0;         ///< L0 of the muscles [m]
  double rest_flexor = 0.0;    ///< contraction at angle 0
  double rest_extensor = 0.0;  ///< likewise
};
/// The log of a joint: `angle_rad`, `muscle_torque_Nm` (what load cells in the lines say, times the radius) or
/// `torque_Nm`, `pressure_flexor_Pa` and `pressure_extensor_Pa`, or one of them where only that muscle pulls.
/// \throws DataError: as readPamLog; neither pressure
PamLog readJointPamLog(CsvTable table, const MusclePulley& pulley);

/// Labels of the `session` column (text or number), which is taken from the table; all 0 when there is none.
/// \param names  set to the labels' texts.
std::vector<int> readSessions(CsvTable& table, std::vector<std::string>& names);

/// \throws DataError at the first row whose time does not rise within its session.
void requireRisingTime(const CsvTable& table, const std::vector<double>& time, const std::vector<int>& session);

}  // namespace simgap
