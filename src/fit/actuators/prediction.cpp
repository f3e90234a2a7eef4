#include "simgap/fit/actuators/prediction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fit/actuators/log_predictor.h"
#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap {

FrictionDataOptions dataOptionsOf(const FittedModel& model) {
  FrictionDataOptions options;
  for (const char* unit : {"rad_s", "m_s"}) {
    if (const auto band = parseNumber(model.setting(quantityName("dead_band", unit)))) options.dead_band = band;
  }
  options.load_is_fitted = model.setting("predicts") == "torque";
  return options;
}

bool isDiagnosed(const FittedModel& model) { return !model.extensions.empty() || model.has(kNuisance); }

Prediction predictLog(const FittedModel& model, const CsvTable& table, const Bench& bench,
                      const PredictionOptions& options) {
  const LogKind& kind = *log_kinds::find(model.kind);
  const auto predictors = log_predictors::all();
  const auto found = std::ranges::find(predictors, kind.kind, &LogPredictor::kind);
  const bool diagnosed = isDiagnosed(model);
  if (options.inverse && (found == predictors.end() || !(*found)->inverts)) {
    throw ConfigError(fmt::format("{}: found a {} model with --inverse, expected a pam, a motor or a gearbox there",
                                  options.file, kind.name));
  }
  if (diagnosed && (options.inverse || (found != predictors.end() && (*found)->undiagnosed))) {
    throw ConfigError(fmt::format("{}: found a diagnosed model {}, expected none there", options.file,
                                  options.inverse ? "with --inverse" : fmt::format("in a {} model", kind.name)));
  }
  if (diagnosed || found == predictors.end()) return predictDiagnosed(model, table, bench);
  return (*found)->predict(model, table, bench, options);
}

Prediction predictDiagnosed(const FittedModel& model, const CsvTable& table, const Bench& bench) {
  const ActuatorModel subject = subjectOf(model);
  const PreparedLog log = prepareLog(table, bench, subject.base.kind, dataOptionsOf(model));
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
