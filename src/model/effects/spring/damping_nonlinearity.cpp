/// \file
/// A force that grows less, or more, than in proportion to the rate of deflection:
///
///     F += c sign(v) |v / v_top|^n,   v_top: the largest rate of the log,
///
/// smooth within a hundredth of v_top, where noise would decide the sign.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::damping_nonlinearity {
namespace {

constexpr double kSmall = 0.01;  // of the top rate
constexpr EffectParameter kParameters[] = {{"n", "1", 0.1, 4.0, 1.0, 0.4, EffectParameter::Kind::kShape}};
constexpr EffectColumn kColumns[] = {{.name = "c", .unit = "A", .lower = 0.0, .torque = false}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  const Eigen::ArrayXd v = rows.speed / std::max(rows.speed.abs().maxCoeff(), 1e-300);
  x.col(0) = v * (v.square() + kSmall * kSmall).pow(0.5 * (p[0] - 1.0));
}

std::vector<std::vector<double>> starts(const ActuatorRows& /*rows*/, const Eigen::ArrayXd& /*residual*/) {
  return {{0.2}, {0.5}, {2.0}};
}

/// Near n = 1 it is damping, which acts where another cause lets the model have none: of a spring within its play.
bool counts(std::span<const double> p, const ActuatorRows& /*rows*/) {
  constexpr double kLinear = 0.15;
  return std::abs(p[0] - 1.0) > kLinear;
}

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kTime};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "damping-nonlinearity",
    .kind = ActuatorKind::kSpring,
    .cause = "the damping is no multiple of the rate: rubber and textiles resist slow motion relatively more",
    .equation = "F += c sign(v) |v / v_top|^n",
    .signature = "loops whose width grows with the rate, but not in proportion, and that close at rest",
    .source = "catalogue of causes",
    .look_alikes = "spring-hysteresis when all motions have one rate; spring-creep",
    .separates = "loops over the same range at rates a factor of ten apart, and rests between them",
    .parameters = kParameters,
    .columns = kColumns,
    .needs = kNeeds,
    .needs_all_rows = true,
    .fill = fill,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::damping_nonlinearity
