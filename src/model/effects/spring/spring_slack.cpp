/// \file
/// A cord only pulls: below its rest length it hangs loose, and neither spring nor damper has any force (000 eq. 4),
///
///     F = stiffness max(x, L_0) + offset + damping dx/dt [x > L_0].
///
/// What is left below L_0, stiffness L_0 + offset, is the reading of the unloaded sensor.
#include "simgap/model/actuator/fitted_model.h"

#include "../deflection_sides.h"

namespace simgap::actuator_effects::spring_slack {
namespace {

constexpr double kNever = -10.0;  // [m] or [rad]: no spring of a log is as short
constexpr EffectParameter kParameters[] = {
    {"rest_length", "rad", kNever, 10.0, kNever, 0.0, EffectParameter::Kind::kShape}};

constexpr OwnParameter kOwn{.law = kCord, .law_without = "", .name = "rest_length", .unit = "", .inverse = false};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.viscous *= dampedShare(terms.deflection - p[0], rows);
  terms.deflection = terms.deflection.max(p[0]);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double low = rows.deflection.minCoeff(), range = rows.deflection.maxCoeff() - low;
  std::vector<std::vector<double>> list;
  for (const double part : {0.3, 0.03, 0.1, 0.2, 0.4, 0.5, 0.7}) list.push_back({low + part * range});
  return list;
}

/// An end of a few rows says nothing about a cord that hangs loose.
bool counts(std::span<const double> p, const ActuatorRows& rows) {
  constexpr double kFewest = 0.02;  // share of the rows
  return (rows.deflection < p[0]).cast<double>().mean() > kFewest;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "spring-slack",
    .kind = ActuatorKind::kSpring,
    .cause = "the cord only pulls: below its rest length it hangs loose",
    .equation = "F = stiffness max(x, L_0) + offset",
    .signature = "force over deflection is flat below a kink",
    .source = "000 eq. 4",
    .look_alikes = "spring-hardening (a toe region), spring-direction",
    .separates = "deflections from well below the rest length, slowly",
    .parameters = kParameters,
    .own_parameter = &kOwn,
    .apply = apply,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::spring_slack
