/// \file
/// A torque sensor whose reading bends over the load, as a bridge with one strain gauge does: tau_ext + c tau_ext^2,
/// or, where it bends alike in both directions, as a beam does that gives way, tau_ext + c |tau_ext| tau_ext.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::torque_sensor_nonlinearity {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kLoadSensor};
constexpr EffectColumn kColumns[] = {{"c", "1_Nm"}};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.load.square();
}

void fillOdd(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
             const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.load.abs() * rows.load;
}

constexpr ActuatorEffect kUsual = {
    .name = "torque-sensor-nonlinearity",
    .form = "gauge",
    .cause = "the torque sensor's reading bends over the load",
    .equation = "tau_ext + c tau_ext^2",
    .signature = "a residual that bends over the load, at rest and in both directions of motion alike",
    .source = "bridges with one strain gauge (data sheets of load cells: non-linearity)",
    .look_alikes = "torque-saturation, load-nonlinearity, joint-gravity",
    .separates = "known weights on the sensor, and the largest loads while the drive lifts and while it lowers",
    .columns = kColumns,
    .needs = kNeeds,
    .of_rows = true,
    .fill = fill,
};

constexpr ActuatorEffect kOdd = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "beam";
  effect.equation = "tau_ext + c |tau_ext| tau_ext";
  effect.fill = fillOdd;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kOdd};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::torque_sensor_nonlinearity
