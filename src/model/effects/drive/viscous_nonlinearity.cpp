/// \file
/// A viscous term that saturates or grows with speed: k_v |w|^m sign(w), written k_v w |w / w_top|^(m - 1), or beside
/// it the drag of a stirred fluid, c w |w|.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::viscous_nonlinearity {
namespace {

constexpr EffectParameter kParameters[] = {{"m", "1", 0.1, 4.0, 1.0, 1.0},
                                           {"w_top", "rad_s", 1e-9, 1e9, 1.0, 1.0, EffectParameter::Kind::kConstant}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.viscous *= ((p[0] - 1.0) * (rows.speed.abs() / p[1]).max(1e-9).log()).exp();
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  return {{1.0, rows.top_speed}, {0.5, rows.top_speed}, {2.0, rows.top_speed}};
}

constexpr EffectColumn kDragColumns[] = {{"c", "Nms2_rad2"}};

void fillDrag(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
              const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.speed * rows.speed.abs();
}

constexpr ActuatorEffect kUsual = {
    .name = "viscous-nonlinearity",
    .form = "power",
    .cause = "viscous friction that saturates or grows with speed",
    .equation = "k_v w |w / w_top|^(m - 1)",
    .signature = "residual x direction bends over the speed",
    .source = "catalogue of causes",
    .look_alikes = "stribeck, inertia, torque-saturation",
    .separates = "at least five constant speeds up to the largest",
    .parameters = kParameters,
    .on_robot = true,
    .apply = apply,
    .starts = starts,
};

constexpr ActuatorEffect kDrag = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "drag";
  effect.equation = "tau_fr += c w |w|";
  effect.parameters = {};
  effect.columns = kDragColumns;
  effect.on_robot = false;
  effect.fill = fillDrag;
  effect.apply = nullptr;
  effect.starts = nullptr;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kDrag};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::viscous_nonlinearity
