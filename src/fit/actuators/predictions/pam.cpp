// A pneumatic muscle: its force, or with `inverse` the pressure that gives the measured one.
#include "simgap/model/actuator/pam.h"

#include <cmath>
#include <limits>

#include "fit/actuators/log_predictor.h"

namespace simgap::log_predictors::pam {
namespace {

Prediction predict(const FittedModel& model, const CsvTable& table, const Bench& /*bench*/,
                   const PredictionOptions& options) {
  const PamLog log = readPamLog(table);
  const Pam muscle{model.value("a"), model.value("b"), model.value("c"),
                   model.valueOr("k", std::numeric_limits<double>::infinity())};
  Prediction result{options.inverse ? "pressure" : "force", options.inverse ? "Pa" : "N", log.time, {}, {}, 0};
  result.measured = options.inverse ? log.pressure : log.force;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    const auto value = options.inverse ? muscle.pressure(log.force[i], log.contraction[i])
                                       : muscle.force(log.pressure[i], log.contraction[i]);
    if (!value) ++result.refused;
    result.predicted.push_back(value.value_or(std::nan("")));
  }
  return result;
}

}  // namespace

extern const LogPredictor entry;
const LogPredictor entry{.kind = ActuatorKind::kPam, .predict = predict, .inverts = true};

}  // namespace simgap::log_predictors::pam
