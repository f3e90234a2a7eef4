#include "simgap/fit/actuators/prediction.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/fit/actuators/fitted_drive.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/measure/logs/log_kind.h"
#include "simgap/model/actuator/friction_drive.h"
#include "simgap/model/actuator/pam.h"

namespace simgap {
namespace {

/// The direction of motion is held as it was when the model was fitted.
FrictionDataOptions dataOptions(const FittedModel& model) {
  FrictionDataOptions options;
  for (const char* unit : {"rad_s", "m_s"}) {
    if (const auto band = parseNumber(model.setting(quantityName("dead_band", unit)))) options.dead_band = band;
  }
  return options;
}

}  // namespace

bool isDiagnosed(const FittedModel& model) { return !model.extensions.empty() || model.has(kNuisance); }

Prediction predictLog(const FittedModel& model, const CsvTable& table, const Bench& bench,
                      const PredictionOptions& options) {
  const ActuatorKind kind = log_kinds::find(model.kind)->kind;
  const bool diagnosed = isDiagnosed(model);
  if (diagnosed && (kind == ActuatorKind::kGearbox || options.inverse)) {
    throw ConfigError(fmt::format("{}: found a diagnosed model {}, expected none there", options.file,
                                  options.inverse ? "with --inverse" : "in a gearbox model"));
  }
  if (kind == ActuatorKind::kSpring && options.inverse) {
    throw ConfigError(options.file + ": found a spring with --inverse, expected a muscle or a drive there");
  }
  if (diagnosed || kind == ActuatorKind::kSpring) return predictDiagnosed(model, table, bench);
  if (kind == ActuatorKind::kFriction) return predictFriction(model, table, bench);
  if (kind == ActuatorKind::kPam) return predictPam(model, table, options.inverse);
  if (kind == ActuatorKind::kMotor) return predictDrive(readMotorLog(table), motorFrom(model), {}, options.inverse);
  if (!options.motor) throw ConfigError("a gearbox model needs --motor MODEL too");
  return predictDrive(readMotorLog(table), motorFrom(*options.motor), gearboxFrom(model), options.inverse);
}

Prediction predictDiagnosed(const FittedModel& model, const CsvTable& table, const Bench& bench) {
  const ActuatorModel subject = subjectOf(model);
  const PreparedLog log = prepareLog(table, bench, subject.base.kind, dataOptions(model));
  const Eigen::ArrayXd predicted = predictExtended(subject, log.data);
  const UnitName effort = splitUnit(log.effort_column);
  Prediction result{effort.stem, effort.unit, {}, {}, {}, 0};
  for (Eigen::Index i = 0; i < predicted.size(); ++i) {
    if (!log.data.keep[i]) continue;
    result.time.push_back(log.data.rows.time[i]);
    result.predicted.push_back(predicted[i]);
    result.measured.push_back(log.data.rows.effort[i]);
  }
  result.refused = static_cast<std::size_t>(predicted.size()) - result.time.size();
  return result;
}

Prediction predictFriction(const FittedModel& model, const CsvTable& table, const Bench& bench) {
  const FrictionData data =
      prepareFrictionData(readActuatorLog(table, {.ratio = bench.ratio.value_or(0.0)}), bench, dataOptions(model));
  const FrictionLaw& law = friction::find(model.law);
  const DriveFeedForward drive = feedForward(law, model.parameters);
  const bool torque = model.setting("predicts") == "torque";
  Prediction result{
      torque ? "external_load" : data.effort_name, torque ? data.load_unit : data.effort_unit, {}, {}, {}, 0};
  std::vector<double> rig;
  for (const std::string& name : data.rig_names) rig.push_back(model.value(name));
  const Eigen::ArrayXd load = data.totalLoad(rig);
  for (Eigen::Index i = 0; i < load.size(); ++i) {
    result.time.push_back(data.time[i]);
    result.measured.push_back(torque ? load[i] : data.effort[i]);
    result.predicted.push_back(torque ? drive.load(data.effort[i], data.velocity[i], data.direction[i])
                                      : drive.effort(load[i], data.velocity[i], data.direction[i]));
  }
  result.refused = data.log_rows - data.rows();
  return result;
}

Prediction predictPam(const FittedModel& model, const CsvTable& table, bool inverse) {
  const PamLog log = readPamLog(table);
  const Pam muscle{model.value("a"), model.value("b"), model.value("c"),
                   model.valueOr("k", std::numeric_limits<double>::infinity())};
  Prediction result{inverse ? "pressure" : "force", inverse ? "Pa" : "N", log.time, {}, {}, 0};
  result.measured = inverse ? log.pressure : log.force;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    const auto value =
        inverse ? muscle.pressure(log.force[i], log.contraction[i]) : muscle.force(log.pressure[i], log.contraction[i]);
    if (!value) ++result.refused;
    result.predicted.push_back(value.value_or(std::nan("")));
  }
  return result;
}

Prediction predictDrive(const MotorLog& log, const Motor& motor, const Gearbox& gearbox, bool inverse) {
  if (log.voltage.empty() && log.current.empty()) {
    throw DataError(log.file + ":1: found neither voltage_V nor current_A, expected one of them");
  }
  const DriveResponse response = simulateDrive(log, motor, gearbox);
  if (inverse) return {"current", "A", log.time, response.current, log.current, 0};
  return {"velocity", "rad_s", log.time, response.velocity, log.velocity, 0};
}

std::optional<double> rmsError(const Prediction& p) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < p.measured.size(); ++i) {
    if (!std::isfinite(p.predicted[i])) continue;
    sum += std::pow(p.predicted[i] - p.measured[i], 2);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace simgap
