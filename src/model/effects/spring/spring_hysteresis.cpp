/// \file
/// Friction inside the spring or along it, at any speed: an elastic bristle that slips (Prandtl 1928),
///
///     F += friction z,   z = clamp(z + dx / z_s, -1, 1),
///
/// or many of them in parallel, which slip one after the other between 0 and 2 z_s (Iwan 1966). Every session begins
/// with the bristles at rest.
#include <algorithm>
#include <array>

#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::spring_hysteresis {
namespace {

constexpr int kBristles = 12;
constexpr EffectParameter kParameters[] = {{"slip", "rad", 1e-7, 10.0, 1.0, 1.0, EffectParameter::Kind::kShape},
                                           {"spread", "1", 0.0, 1.0, 0.0, 0.0, EffectParameter::Kind::kConstant}};
constexpr EffectColumn kColumns[] = {{.name = "friction", .unit = "Nm", .lower = 0.0, .torque = false}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  std::array<double, kBristles> slip{}, bent{};
  const std::size_t count = p[1] > 0.0 ? kBristles : 1;
  double whole = 0.0;
  for (std::size_t b = 0; b < count; ++b) {
    const double place = (2.0 * static_cast<double>(b) + 1.0) / static_cast<double>(count);  // 0 to 2
    slip[b] = p[0] * (1.0 + p[1] * (place - 1.0));
    whole += slip[b];
  }
  const Eigen::ArrayXd& deflection = terms.deflection;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool begins = i == 0 || rows.session[k] != rows.session[k - 1];
    if (begins) bent.fill(0.0);
    const double moved = begins ? 0.0 : deflection[i] - deflection[i - 1];
    double sum = 0.0;
    for (std::size_t b = 0; b < count; ++b) {
      bent[b] = std::clamp(bent[b] + moved, -slip[b], slip[b]);
      sum += bent[b];
    }
    x(i, 0) = sum / whole;
  }
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double range = rows.deflection.maxCoeff() - rows.deflection.minCoeff();
  std::vector<std::vector<double>> list;
  for (const double spread : {0.0, 1.0}) {
    for (const double part : {0.003, 0.01, 0.03, 0.1, 0.2, 0.3}) list.push_back({part * range, spread});
  }
  return list;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "spring-hysteresis",
    .kind = ActuatorKind::kSpring,
    .cause = "friction inside the spring or along it: force runs round a loop, and the spring softens with amplitude",
    .equation = "F += friction z, z = clamp(z + dx / slip, -1, 1)",
    .signature = "force over deflection runs round a loop that is as wide at every speed",
    .remarks =
        "stiffer by `friction` / `slip` until the bristles slip: all at one distance (`spread` = 0) or one after the "
        "other "
        "from 0 to twice `slip` (`spread` = 1), as the data choose",
    .source = "Prandtl 1928; Iwan 1966",
    .look_alikes = "spring-creep when all motions have one speed, damping, spring-softening at one amplitude",
    .separates = "the same loop at speeds ten times apart, and loops of several amplitudes",
    .parameters = kParameters,
    .columns = kColumns,
    .needs_all_rows = true,
    .fill = fill,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::spring_hysteresis
