/// \file
/// What an actuator's log is explained by before any cause is added: a friction law, or one of the equations here,
/// which are linear in their parameters:
///
///     effort = sum_j c_j x_j
///
/// One file of src/model/actuator/equations per kind of log, found by CMake.
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
std::span<const ActuatorEquation* const> all();
/// The equation of a kind of log; nullptr where a friction law explains it.
const ActuatorEquation* find(ActuatorKind kind);
}  // namespace actuator_equations

/// Either of the two.
struct ActuatorBase {
  ActuatorBase(const FrictionLaw& friction, ActuatorKind of = {}) : law(&friction), kind(of) {}
  ActuatorBase(const ActuatorEquation& other) : equation(&other), kind(other.kind) {}

  std::string_view name() const { return law != nullptr ? law->name : equation->name; }
  bool hasStribeck() const { return law != nullptr && law->hasStribeck(); }

  const FrictionLaw* law = nullptr;
  const ActuatorEquation* equation = nullptr;
  ActuatorKind kind;
};

}  // namespace simgap
