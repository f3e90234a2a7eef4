/// \file
/// What an actuator's log is explained by before any cause is added: a friction law, or one of the equations here,
/// which are linear in their parameters:
///
///     effort = sum_j c_j x_j
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

#include "simgap/model/drive_effect.h"
#include "simgap/model/friction_law.h"

namespace simgap {

struct DriveEquation {
  std::string_view name;
  DriveKind kind;
  std::span<const EffectColumn> columns;  ///< shape (C)
  /// \param x  shape (n, C).
  void (*fill)(const DriveRows& rows, const DriveTerms& terms, Eigen::Ref<Eigen::ArrayXXd> x);
};

namespace drive_equations {
extern const DriveEquation winding;  ///< V = R i + L di/dt + K_E w (000 eq. 8)
extern const DriveEquation muscle;   ///< f = p (a e^2 + b e + c), e the muscle's own contraction (002 eq. 14)
/// theta = theta_M / r + offset - lag w_M: a rigid transmission whose two encoders are not read at the same moment.
extern const DriveEquation transmission;
}  // namespace drive_equations

/// Either of the two.
struct DriveBase {
  DriveBase(const FrictionLaw& friction, DriveKind of = DriveKind::kFriction) : law(&friction), kind(of) {}
  DriveBase(const DriveEquation& other) : equation(&other), kind(other.kind) {}

  std::string_view name() const { return law != nullptr ? law->name : equation->name; }
  bool hasStribeck() const { return law != nullptr && law->hasStribeck(); }

  const FrictionLaw* law = nullptr;
  const DriveEquation* equation = nullptr;
  DriveKind kind;
};

}  // namespace simgap
