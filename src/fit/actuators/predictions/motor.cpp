// A motor: its velocity from voltage or current, or with `inverse` its current.
#include "fit/actuators/log_predictor.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/fitted_drive.h"

namespace simgap {

Prediction predictDrive(const MotorLog& log, const Motor& motor, const Gearbox& gearbox, const DriveDelays& delays,
                        bool inverse) {
  if (log.voltage.empty() && log.current.empty()) {
    throw DataError(log.file + ":1: found neither voltage_V nor current_A, expected one of them");
  }
  const DriveResponse response = simulateDrive(log, motor, gearbox, delays);
  if (inverse) return {"current", "A", log.time, response.current, log.current, 0};
  return {"velocity", "rad_s", log.time, response.velocity, log.velocity, 0};
}

namespace log_predictors::motor {
namespace {

Prediction predict(const FittedModel& model, const CsvTable& table, const Bench& /*bench*/,
                   const PredictionOptions& options) {
  const MotorLog log = readMotorLog(table);
  return predictDrive(log, motorFrom(model), {}, delaysFrom(model, log), options.inverse);
}

}  // namespace

extern const LogPredictor entry;
const LogPredictor entry{.kind = ActuatorKind::kMotor, .predict = predict, .inverts = true};

}  // namespace log_predictors::motor
}  // namespace simgap
