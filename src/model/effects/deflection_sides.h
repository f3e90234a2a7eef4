/// \file
/// How the effects on springs that bend the curve of force over deflection are written: relative to the deflection
/// without force, and to the largest one, so that their sizes are stiffnesses.
#pragma once

#include <algorithm>
#include <vector>

#include "simgap/core/statistics.h"
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects {

/// Deflection without force: the median over the rows with the least of it.
inline double unloadedDeflection(const ActuatorRows& rows) {
  constexpr double kLeast = 0.05;  // share of the rows
  std::vector<std::pair<double, double>> by_force;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) by_force.emplace_back(std::abs(rows.effort[i]), rows.deflection[i]);
  const auto count = std::max<std::size_t>(1, static_cast<std::size_t>(kLeast * static_cast<double>(by_force.size())));
  std::ranges::nth_element(by_force, by_force.begin() + static_cast<std::ptrdiff_t>(count - 1));
  std::vector<double> least;
  for (std::size_t i = 0; i < count; ++i) least.push_back(by_force[i].second);
  return upperMedian(std::move(least));
}

/// The largest deflection from there.
inline double furthestDeflection(const ActuatorRows& rows, double origin) {
  return std::max((rows.deflection - origin).abs().maxCoeff(), 1e-12);
}

/// The share of its force that a damper beside a spring has, shape (n): all of it beyond the edge of where both hang
/// loose, and none a little within. At once it would be a jump, which has no derivative and which no search crosses.
/// \param beyond  how far beyond the edge, below 0 within, shape (n)
inline Eigen::ArrayXd dampedShare(const Eigen::ArrayXd& beyond, const ActuatorRows& rows) {
  constexpr double kLittle = 0.005;  // of the range
  const double range = rows.deflection.maxCoeff() - rows.deflection.minCoeff();
  return (1.0 + beyond / std::max(kLittle * range, 1e-12)).max(0.0).min(1.0);
}

/// What bends a curve: with u = |e| / reach, on either side of its own,
///
///     e u^(exponent - 1) / (1 - saturation + saturation u),
///
/// 1 x e at u = 1. Origin and form are fitted from several starts: with one of a few forms instead, what it lacks of
/// the curve would be named for itself, as a bend the other way. Reach is a reference.
inline constexpr EffectParameter kBendOrigin = {
    "origin", "rad", -100.0, 100.0, 0.0, 0.0, EffectParameter::Kind::kShape};
inline constexpr EffectParameter kReach = {"reach", "rad", 1e-12, 100.0, 1.0, 1.0, EffectParameter::Kind::kConstant};
struct BendForm {
  double exponent, saturation;
};
inline constexpr EffectColumn kBendColumns[] = {{.name = "positive", .unit = "Nm_rad", .lower = 0.0, .torque = false},
                                                {.name = "negative", .unit = "Nm_rad", .lower = 0.0, .torque = false}};

/// \param x  shape (n, 2): of positive and of negative deflection; times `sign`.
inline void fillBend(std::span<const double> p, const Eigen::ArrayXd& deflection, double sign,
                     Eigen::Ref<Eigen::ArrayXXd> x) {
  const Eigen::ArrayXd e = deflection - p[2], u = e.abs() / p[3];
  const Eigen::ArrayXd bend = sign * e * u.pow(p[0] - 1.0) / (1.0 - p[1] + p[1] * u);
  x.col(0) = (e > 0.0).select(bend, 0.0);
  x.col(1) = (e < 0.0).select(bend, 0.0);
}

/// From each form, about a place.
inline std::vector<std::vector<double>> bendStarts(const ActuatorRows& rows, double origin,
                                                   std::span<const BendForm> forms) {
  const double reach = furthestDeflection(rows, origin);
  std::vector<std::vector<double>> starts;
  for (const auto& [exponent, saturation] : forms) starts.push_back({exponent, saturation, origin, reach});
  return starts;
}

/// A curve that bends about another place than where there is no force has a kink there, or begins there.
inline bool bendsAboutRest(std::span<const double> p, const ActuatorRows& rows) {
  constexpr double kFar = 0.1;  // of the reach
  return std::abs(p[2] - unloadedDeflection(rows)) < kFar * p[3];
}

}  // namespace simgap::actuator_effects
