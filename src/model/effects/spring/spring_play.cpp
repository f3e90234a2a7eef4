/// \file
/// There is play in series with the spring, as of a gear or a loose end: within it nothing is stretched, and neither
/// spring nor damper behind it has any force,
///
///     F = stiffness (x - clamp(x - middle, -play / 2, play / 2)) + offset + damping dx/dt,
///
/// or, where the damper sits beside spring and play (`beside` = 1), with its force within, too.
#include "../deflection_sides.h"

namespace simgap::actuator_effects::spring_play {
namespace {

constexpr EffectParameter kParameters[] = {{"play", "rad", 0.0, 10.0, 0.0, 0.0},
                                           {"middle", "rad", -100.0, 100.0, 0.0, 0.0, EffectParameter::Kind::kShape},
                                           {"beside", "1", 0.0, 1.0, 0.0, 0.0, EffectParameter::Kind::kConstant}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const Eigen::ArrayXd e = terms.deflection - p[1];
  const double half = 0.5 * p[0];
  if (p[2] == 0.0) terms.viscous *= dampedShare(e.abs() - half, rows);
  terms.deflection -= e.max(-half).min(half);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double range = rows.deflection.maxCoeff() - rows.deflection.minCoeff(), middle = unloadedDeflection(rows);
  std::vector<std::vector<double>> list;
  for (const double part : {0.01, 0.03, 0.1, 0.3}) {
    for (const double beside : {0.0, 1.0}) list.push_back({part * range, middle, beside});
  }
  return list;
}

/// What is hardly pulled beyond one of its ends is a cord that hangs loose.
bool counts(std::span<const double> p, const ActuatorRows& rows) {
  constexpr double kFewest = 0.02;       // of the rows
  constexpr double kFewestWithin = 5.0;  // rows
  constexpr double kBeyond = 0.05;       // of the range
  const Eigen::ArrayXd e = rows.deflection - p[1];
  const double half = 0.5 * p[0], low = e.minCoeff(), high = e.maxCoeff();
  if (std::min(-half - low, high - half) < kBeyond * (high - low)) return false;
  const auto rowsOf = [](const auto& which) { return which.template cast<double>().sum(); };
  const double fewest = kFewest * static_cast<double>(e.size());
  return rowsOf(e < -half) > fewest && rowsOf(e > half) > fewest && rowsOf(e.abs() < half) >= kFewestWithin;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "spring-play",
    .kind = ActuatorKind::kSpring,
    .cause = "there is play in series with the spring: within it nothing is stretched",
    .equation = "F = stiffness (x - clamp(x - middle, -play / 2, play / 2)) + offset",
    .signature = "force over deflection is flat between two kinks, and equally steep beyond both",
    .remarks = "a damper resists within the play (`beside` = 1) or beyond it only, as the data choose",
    .source = "Nordin & Gutman 2002",
    .look_alikes = "spring-direction and spring-slack where one side is hardly loaded, spring-hardening",
    .separates = "many slow crossings of the deflection without force, with small amplitudes on either side",
    .parameters = kParameters,
    .apply = apply,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::spring_play
