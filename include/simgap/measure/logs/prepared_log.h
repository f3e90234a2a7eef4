/// \file
/// A log made ready for models and effects (simgap/model/effects/actuator_effect.h): all rows stay, in order, with a
/// mark on those that mean nothing.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/measure/logs/actuator_rows.h"
#include "simgap/measure/logs/friction_rows.h"
#include "simgap/optimize/least_squares.h"

namespace simgap {

/// A log with its rows' meaning.
struct ActuatorData {
  ActuatorRows rows;
  std::vector<bool> keep;                     ///< shape (n): rows that count
  Eigen::ArrayXXd rig;                        ///< shape (n, R): load per unit of each fitted constant of the rig
  std::vector<ParameterSpec> rig_parameters;  ///< shape (R)
  bool offset = false;                        ///< the model has a current offset of its own
  std::string load_unit = "Nm", effort_unit = "A", velocity_unit = "rad_s";
};

/// A column of the log that is none of the model's channels, or a channel by name.
struct ContextChannel {
  std::string name;
  Eigen::ArrayXd values;  ///< shape (n)
};

struct PreparedLog {
  ActuatorKind kind = ActuatorKind::kFriction;
  ActuatorData data;
  std::vector<Block> blocks;            ///< of 4 to 20 s, shorter in short logs; held out together
  std::vector<ContextChannel> context;  ///< in the order of ActuatorRows::context
  std::vector<std::string> session_names;
  std::string file, effort_column;
  double dead_band = 0.0;
  std::vector<ChannelSpikes> spikes;   ///< samples that stood alone; their rows do not count
  std::vector<ChannelSpikes> clipped;  ///< of a spring: a sensor at its limit; likewise
  std::vector<std::string> warnings;
};

/// \param table  the log itself: joint angle, temperature and further channels are read from it.
/// \throws DataError as readActuatorLog and prepareFrictionData.
PreparedLog prepareActuatorData(const CsvTable& table, const Bench& bench, const ActuatorLogOptions& log_options,
                                FrictionDataOptions options);

/// The same for a motor with a gearbox on a bench, whose voltages and loads are often stepped.
PreparedLog prepareGearboxData(const CsvTable& table, const Bench& bench, const ActuatorLogOptions& log_options,
                               const FrictionDataOptions& options);

/// The same for a winding's log (voltage, current, speed) and for a pneumatic muscle's.
/// \throws DataError as readMotorLog and readPamLog, and when there is no voltage, current or velocity.
PreparedLog prepareMotorData(const CsvTable& table);
PreparedLog preparePamData(const CsvTable& table);

/// The same for a spring. Its rests stay: what its force does while nothing moves is creep. Samples that stand alone
/// and sensors at their limit do not count. \throws DataError as readSpringLog.
PreparedLog prepareSpringData(const CsvTable& table);

/// The one of them that suits a model of that kind; the rig's bandwidth and ratio replace those of `options`.
PreparedLog prepareLog(const CsvTable& table, const Bench& bench, ActuatorKind kind, FrictionDataOptions options = {});

/// The same rows to explain the joint's angle by the motor's; the log must have both.
PreparedLog prepareTransmissionData(const PreparedLog& drive);

}  // namespace simgap
