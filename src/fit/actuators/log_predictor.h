/// \file
/// How a fit's own model predicts a log of its kind. One file of src/fit/actuators/predictions per kind, found by
/// CMake; a kind without one is predicted as a diagnosed model is.
#pragma once

#include <span>

#include "simgap/fit/actuators/prediction.h"

namespace simgap {

struct LogPredictor {
  ActuatorKind kind;
  Prediction (*predict)(const FittedModel& model, const CsvTable& table, const Bench& bench,
                        const PredictionOptions& options);
  bool inverts = false;      ///< PredictionOptions::inverse means something
  bool undiagnosed = false;  ///< a model of `diagnose` cannot be predicted
};

namespace log_predictors {
std::span<const LogPredictor* const> all();
}

/// A drive's velocity, or with `inverse` its current, of a log that has a voltage or a current.
/// \throws DataError: neither in the log.
Prediction predictDrive(const MotorLog& log, const Motor& motor, const Gearbox& gearbox, const DriveDelays& delays,
                        bool inverse);

}  // namespace simgap
