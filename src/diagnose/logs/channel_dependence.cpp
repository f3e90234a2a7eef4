#include "channel_dependence.h"

namespace simgap {
namespace {

using Kind = EffectParameter::Kind;

constexpr EffectParameter kParameters[] = {{"a", "1", -0.9, 0.9, 0.0, 0.0},
                                           {"b", "1", -0.5, 0.5, 0.0, 0.0},
                                           {"channel", "1", 0.0, 1e6, 0.0, 0.0, Kind::kConstant},
                                           {"second", "1", -1.0, 1e6, -1.0, -1.0, Kind::kConstant}};
constexpr EffectColumn kColumns[] = {{.name = "c", .unit = "A", .torque = false},
                                     {.name = "d", .unit = "A", .torque = false}};

Eigen::ArrayXd channelOf(std::span<const double> p, const ActuatorRows& rows) {
  const Eigen::ArrayXd& u = rows.context[static_cast<std::size_t>(p[2])];
  return p[3] < 0.0 ? u : Eigen::ArrayXd(u * rows.context[static_cast<std::size_t>(p[3])]);
}

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const Eigen::ArrayXd u = channelOf(p, rows);
  const Eigen::ArrayXd factor = (1.0 + p[0] * u + p[1] * u.square()).max(0.02);
  terms.dry *= factor;
  terms.viscous *= factor;
  if (terms.pressure.size() > 0) terms.pressure *= factor;
}

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  const Eigen::ArrayXd u = channelOf(p, rows);
  x.col(0) = u;
  x.col(1) = u.square();
}

}  // namespace

const ActuatorEffect kChannelDependence = {
    .name = "channel-dependence",
    .cause = "friction or effort that depends on a logged channel in a way no named cause explains",
    .equation = "tau_fr (1 + a u + b u^2), I + c u + d u^2",
    .signature = "structure over a channel that is left by every named cause",
    .source = "not a cause: what names the channel of an unknown one",
    .look_alikes = "",
    .separates = "the channel stepped up and down while all else repeats",
    .parameters = kParameters,
    .columns = kColumns,
    .apply = apply,
    .fill = fill,
};

}  // namespace simgap
