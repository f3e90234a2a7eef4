/// \file
/// A drive's log made ready for effects (simgap/fit/drive_regression.h): all rows stay, in order, with a mark on those
/// that mean nothing.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/fit/drive_regression.h"
#include "simgap/fit/friction_data.h"
#include "simgap/model/fitted_model.h"

namespace simgap {

/// A column of the log that is none of the model's channels, or a channel by name.
struct ContextChannel {
  std::string name;
  Eigen::ArrayXd values;  ///< shape (n)
};

struct PreparedLog {
  DriveKind kind = DriveKind::kFriction;
  DriveData data;
  std::vector<Block> blocks;            ///< of 4 to 20 s, shorter in short logs; held out together
  std::vector<ContextChannel> context;  ///< in the order of DriveRows::context
  std::vector<std::string> session_names;
  std::string file, effort_column;
  double dead_band = 0.0;
  std::vector<std::string> warnings;
};

/// \param table  the log itself: joint angle, temperature and further channels are read from it.
/// \throws DataError as readDriveLog and prepareFrictionData.
PreparedLog prepareDriveData(const CsvTable& table, const Bench& bench, const DriveLogOptions& log_options,
                             FrictionDataOptions options);

/// The same for a motor with a gearbox on a bench, whose voltages and loads are often stepped.
PreparedLog prepareGearboxData(const CsvTable& table, const Bench& bench, const DriveLogOptions& log_options,
                               const FrictionDataOptions& options);

/// The same for a winding's log (voltage, current, speed) and for a pneumatic muscle's.
/// \throws DataError as readMotorLog and readPamLog, and when there is no voltage, current or velocity.
PreparedLog prepareMotorData(const CsvTable& table);
PreparedLog prepareMuscleData(const CsvTable& table);

/// The same rows to explain the joint's angle by the motor's; the log must have both.
PreparedLog prepareTransmissionData(const PreparedLog& drive);

/// A model as the user has it.
struct DriveSubject {
  DriveBase base;
  std::vector<const DriveEffect*> effects;  ///< of its extensions
  std::vector<PhysicalParameter> values;    ///< as the file holds them; empty for a law alone
  std::vector<Extension> of_angles = {};    ///< extensions that say nothing about the effort: of the transmission
};

/// A muscle's spring is an effect on top of 002 eq. 14, the inertia of a gearbox one on top of Coulomb friction.
/// \throws ConfigError: an unknown law or effect, a parameter that an effect does not have.
DriveSubject subjectOf(const FittedModel& model);
/// A friction law, "motor", "gearbox" or "pam". \throws ConfigError: an unknown name.
DriveSubject subjectOf(std::string_view name);

/// What an extended model predicts for a log, shape (rows).
Eigen::ArrayXd predictExtended(const DriveSubject& subject, const DriveData& data);

}  // namespace simgap
