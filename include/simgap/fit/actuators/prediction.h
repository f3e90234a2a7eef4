/// \file
/// What a fitted model predicts for a log: a drive's effort or load, a muscle's force or pressure, a motor's response.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/drive_fit.h"
#include "simgap/measure/logs/prepared_log.h"
#include "simgap/model/actuator/fitted_model.h"

namespace simgap {

/// A predicted column and, when the log has it, the measured one.
struct Prediction {
  std::string name, unit;         ///< "motor_current", "A"
  std::vector<double> time;       ///< shape (rows) [s]; empty when the log has none
  std::vector<double> predicted;  ///< shape (rows); NaN outside the model's range
  std::vector<double> measured;   ///< shape (rows); empty when the log has none
  std::size_t refused = 0;        ///< rows outside the model's range, or left out
};

/// What else a prediction may need.
struct PredictionOptions {
  bool inverse = false;              ///< a muscle's pressure from its force, a drive's current
  std::optional<FittedModel> motor;  ///< of a gearbox
  std::string file;                  ///< of the model, for messages
};

/// Whether it is a model of `diagnose`, predicted on the rows that mean something.
bool isDiagnosed(const FittedModel& model);

/// How its log is prepared: the direction of motion is held as it was when the model was fitted.
FrictionDataOptions dataOptionsOf(const FittedModel& model);

/// As the kind of the model predicts it (src/fit/actuators/predictions), or as predictDiagnosed.
/// \param bench  of a drive under load; the others have none
/// \throws ConfigError: `inverse` of a diagnosed model or where it means nothing, a diagnosed gearbox, a gearbox
///         without its motor; DataError as the reader of the kind, and where a motor's log has neither voltage nor
///         current.
Prediction predictLog(const FittedModel& model, const CsvTable& table, const Bench& bench,
                      const PredictionOptions& options);

/// A model of `diagnose`, its law with presliding and extensions, on the rows that mean something: what a motor draws,
/// the voltage of a winding, the force of a muscle. \throws DataError as prepareLog.
Prediction predictDiagnosed(const FittedModel& model, const CsvTable& table, const Bench& bench);

/// Root of the mean squared error against the log; empty when there is nothing to compare with.
std::optional<double> rmsError(const Prediction& prediction);

}  // namespace simgap
