// A drive under load: the motor's effort, or the load of a model that was fitted to predict it.
#include "simgap/model/actuator/friction_drive.h"
#include "fit/actuators/log_predictor.h"
#include "simgap/fit/actuators/friction_fit.h"

namespace simgap::log_predictors::friction_drive {
namespace {

Prediction predict(const FittedModel& model, const CsvTable& table, const Bench& bench,
                   const PredictionOptions& /*options*/) {
  const FrictionData data =
      prepareFrictionData(readActuatorLog(table, {.ratio = bench.ratio.value_or(0.0)}), bench, dataOptionsOf(model));
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

}  // namespace

extern const LogPredictor entry;
const LogPredictor entry{.kind = ActuatorKind::kFriction, .predict = predict};

}  // namespace simgap::log_predictors::friction_drive
