/// \file
/// A friction law: one file in src/model/friction/laws, found by CMake. All laws here share one shape, in which
/// everything but the Stribeck velocity and exponent is linear:
///
///     tau_fr = sum_j theta_j x_j w_j,     x_j in {|tau_ext| sign(w), sign(w), w},   w_j in {1, 1 - E, E},
///     E      = exp(-|w / v_s|^delta)
///
/// so that a fit searches two numbers at most and solves for the rest.
#pragma once

#include <span>
#include <string_view>

#include "simgap/model/actuator/feed_forward.h"

namespace simgap {

/// What a term is proportional to.
enum class FrictionBasis {
  kLoad,       ///< |tau_ext| sign(w); parameter in 1
  kDirection,  ///< sign(w); parameter in N m
  kVelocity,   ///< w; parameter in N m s/rad
};

/// At which speeds a term acts.
enum class FrictionShape {
  kAlways,
  kSliding,  ///< 1 - E: Coulomb friction
  kStatic,   ///< E: static friction
};

struct FrictionTerm {
  std::string_view name;
  FrictionBasis basis;
  FrictionShape shape;
};

struct FrictionLaw {
  std::string_view name;                ///< "variant-a"
  std::string_view summary;             ///< one line
  std::string_view equation;            ///< of the friction torque
  std::string_view source;              ///< paper and equation
  std::span<const FrictionTerm> terms;  ///< shape (T)
  /// The same law as the closed form that simulators and controllers use. \param theta  shape (T).
  StribeckFriction (*closed_form)(std::span<const double> theta);

  /// True when v_s and delta matter.
  bool hasStribeck() const {
    for (const FrictionTerm& term : terms) {
      if (term.shape != FrictionShape::kAlways) return true;
    }
    return false;
  }
  bool hasTerm(FrictionBasis basis, FrictionShape shape) const {
    for (const FrictionTerm& term : terms) {
      if (term.basis == basis && term.shape == shape) return true;
    }
    return false;
  }
  bool needsLoad() const {
    for (const FrictionTerm& term : terms) {
      if (term.basis == FrictionBasis::kLoad) return true;
    }
    return false;
  }
};

namespace friction {
std::span<const FrictionLaw* const> all();
/// \throws ConfigError that lists the known laws.
const FrictionLaw& find(std::string_view name);
}  // namespace friction

}  // namespace simgap
