/// \file
/// More friction in a joint, more damping in the cords: what ordinary parameters of every fit carry is no effect beside
/// the model. It shows as a shift against what was known before.
#pragma once

#include <optional>
#include <string_view>

#include "motion_fit.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// Parameters that moved together, further than what is known of them lets expect.
struct OrdinaryShift {
  Cause cause;           ///< joint-viscous, joint-coulomb or cord-damping, with the factor found
  Eigen::VectorXd back;  ///< the fit's z with these at what was expected
  std::string_view separates_by;
};

/// The group that moved furthest; none where chance moves one of all groups as far in one of 200 arms. Others that
/// moved about as improbably are named beside it.
std::optional<OrdinaryShift> furthestShift(const MotionCauseFit& fit);

}  // namespace simgap
