/// \file
/// A friction law over the rows of a log: its parameters with their bounds, the Stribeck factor and the terms' columns.
/// Fits that need a law's columns take them from here; StribeckMoments sums up their products faster.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/model/friction/friction_law.h"
#include "simgap/optimize/parameter.h"

namespace simgap {

/// The law's linear parameters, >= 0, shape (T). \param load_unit  "Nm" or "N"
std::vector<ParameterSpec> termParameters(const FrictionLaw& law, std::string_view load_unit);

/// Of k_a: load per effort.
std::string gainUnit(const std::string& load_unit, const std::string& effort_unit);

/// v_s and delta; empty for a law without them. The box holds every curve that differs from its limits on a log: with
/// v_s above its range E is 1 up to the largest speed, below it 0 but for a few rows; a delta beyond 20 makes a step,
/// one below 0.05 a constant. \param top_speed  largest |w|
std::vector<ParameterSpec> stribeckParameters(const FrictionLaw& law, double top_speed, std::string_view velocity_unit);

struct StribeckFactor {
  Eigen::ArrayXd exponent;  ///< |w / v_s|^delta, shape (n); at most e^50, beyond which E is 0 anyway
  Eigen::ArrayXd value;     ///< E = exp(-exponent), shape (n)
};
/// \param log_speed  ln |w|, shape (n)
StribeckFactor stribeckFactor(const Eigen::Ref<const Eigen::ArrayXd>& log_speed, double v_s, double delta);

/// Calls `visit` with a term's column before its shape, an expression of shape (n).
/// \param load_size  |tau_ext|  \param dry  sign(w), or what replaces it  \param velocity  w
template <typename Load, typename Dry, typename Velocity, typename Visit>
void visitBasis(FrictionBasis basis, const Load& load_size, const Dry& dry, const Velocity& velocity,
                const Visit& visit) {
  switch (basis) {
    case FrictionBasis::kLoad:
      return visit(load_size * dry);
    case FrictionBasis::kDirection:
      return visit(dry);
    case FrictionBasis::kVelocity:
      return visit(velocity);
  }
}

/// Calls `visit` with a column in its shape, an expression of shape (n). \param factor  E, shape (n)
template <typename Column, typename Factor, typename Visit>
void visitShape(FrictionShape shape, const Column& column, const Factor& factor, const Visit& visit) {
  switch (shape) {
    case FrictionShape::kAlways:
      return visit(column);
    case FrictionShape::kSliding:
      return visit(column * (1.0 - factor));
    case FrictionShape::kStatic:
      return visit(column * factor);
  }
}

}  // namespace simgap
