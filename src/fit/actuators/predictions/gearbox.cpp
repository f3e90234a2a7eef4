// A gearbox on its motor: the drive's velocity, or with `inverse` its current.
#include "fit/actuators/log_predictor.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/fitted_drive.h"

namespace simgap::log_predictors::gearbox {
namespace {

Prediction predict(const FittedModel& model, const CsvTable& table, const Bench& /*bench*/,
                   const PredictionOptions& options) {
  if (!options.motor) throw ConfigError("a gearbox model needs --motor MODEL too");
  const MotorLog log = readMotorLog(table);
  return predictDrive(log, motorFrom(*options.motor), gearboxFrom(model), delaysFrom(model, log), options.inverse);
}

}  // namespace

extern const LogPredictor entry;
const LogPredictor entry{.kind = ActuatorKind::kGearbox, .predict = predict, .inverts = true, .undiagnosed = true};

}  // namespace simgap::log_predictors::gearbox
