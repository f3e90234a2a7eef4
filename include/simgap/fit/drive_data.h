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
  DriveData data;
  std::vector<Block> blocks;            ///< of 4 to 20 s, held out together
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

/// A friction model as the user has it.
struct DriveSubject {
  const FrictionLaw* law;
  std::vector<const DriveEffect*> effects;  ///< of its extensions
  std::vector<PhysicalParameter> values;    ///< as the file holds them; empty for a law alone
};

/// \throws ConfigError: another kind than friction, an unknown law or effect, a parameter that an effect does not have.
DriveSubject subjectOf(const FittedModel& model);

/// What an extended friction model predicts for a log, shape (rows).
Eigen::ArrayXd predictExtended(const DriveSubject& subject, const DriveData& data);

}  // namespace simgap
