/// \file
/// What an actuator's log is explained by before any cause is added: a friction law, or one of the equations here,
/// which are linear in their parameters:
///
///     effort = sum_j c_j x_j
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap {

struct ActuatorEquation {
  std::string_view name;
  ActuatorKind kind;
  std::span<const EffectColumn> columns;  ///< shape (C)
  /// \param x  shape (n, C).
  void (*fill)(const ActuatorRows& rows, const ActuatorTerms& terms, Eigen::Ref<Eigen::ArrayXXd> x);
};

namespace actuator_equations {
extern const ActuatorEquation winding;  ///< V = R i + L di/dt + K_E w (000 eq. 8)
extern const ActuatorEquation muscle;   ///< f = p (a e^2 + b e + c), e the muscle's own contraction (002 eq. 14)
/// F = stiffness x + offset + damping dx/dt (000 eq. 2-3), x the deflection, counted from anywhere.
extern const ActuatorEquation spring;
/// theta = theta_M / r + offset - lag w_M: a rigid transmission whose two encoders are not read at the same moment.
extern const ActuatorEquation transmission;
}  // namespace actuator_equations

/// Either of the two.
struct ActuatorBase {
  ActuatorBase(const FrictionLaw& friction, ActuatorKind of = ActuatorKind::kFriction) : law(&friction), kind(of) {}
  ActuatorBase(const ActuatorEquation& other) : equation(&other), kind(other.kind) {}

  std::string_view name() const { return law != nullptr ? law->name : equation->name; }
  bool hasStribeck() const { return law != nullptr && law->hasStribeck(); }

  const FrictionLaw* law = nullptr;
  const ActuatorEquation* equation = nullptr;
  ActuatorKind kind;
};

}  // namespace simgap
