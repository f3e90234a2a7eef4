/// \file
/// Friction in slow motion of any shape. A law gives its fall from rest to sliding one closed form (003 eq. 4); drives
/// have others: a Lorentzian, bristles that damp their own motion (LuGre: Canudas de Wit et al. 1995), a lubricant that
/// is late. What a closed form leaves there is no evidence for a cause that acts elsewhere, such as viscous friction
/// that is not linear: each has to explain something beside a curve that is free wherever motion is slow.
#pragma once

#include <optional>

#include "log_hypotheses.h"

namespace simgap {

/// The law's own static friction times a broken line over log |w|, zero from w_slow on. Not a cause: what others stand
/// beside.
extern const ActuatorEffect kSlowFriction;

/// Two models with friction of any shape in slow motion beside them.
struct BesideSlow : Beside {
  double below = 0.0;  ///< [rad/s] or [m/s] what counts as slow
};

/// Slow is what lies below a quarter of the log's fast motion. None without a law.
/// \param of_any_load  with a constant part and one in proportion to the load, whichever the law has; else with those
/// of the law
std::optional<BesideSlow> besideSlowFriction(const LogSearch& search, const Fitted& rest, const Fitted& full,
                                             bool of_any_load);

}  // namespace simgap
