/// \file
/// Which motions to record next so that the models of a diagnosis fall apart: those it was made of, slower and faster.
/// What each is expected to tell of a pair is foreseen as of a change (motion_intervention.h), by derivatives; what
/// several tell of a pair adds up. They are chosen one after the other so that the pair that is told apart worst is
/// told apart best, and no more of them than a decision takes.
#pragma once

#include <string>
#include <vector>

#include "simgap/intervene/motions/motion_intervention.h"

namespace simgap {

/// What a motion may not exceed, as the named model expects it.
struct MotionLimits {
  double tension = kInfinity;   ///< [N] of a muscle
  double current = kInfinity;   ///< [A] of a muscle's motor
  double duration = kInfinity;  ///< [s]
};

/// One motion that may be recorded.
struct MotionProtocol {
  PlannedMotion motion;     ///< one that was recorded, in another time
  double speed = 1.0;       ///< so many times as fast
  std::string beyond = {};  ///< which limit it exceeds, and by what: "81.2 N of biceps"; it is not asked then
  ForeseenChange foreseen = {};
  int chosen = 0;  ///< its place among those to record, from 1; 0: not one of them
};

struct MotionSeparation {
  std::vector<MotionProtocol> protocols;
  std::vector<double> smallest;  ///< shape (chosen): log odds of the worst pair after 1, 2 … of them
};

/// \param speeds  > 0 \param most  to choose at most
/// \throws ConfigError: no candidate contradicts the named one, or every motion is beyond the limits. NumericsError: it
/// cannot play one. InterruptedError
MotionSeparation separateMotions(const MotionEvidence& evidence, const std::vector<double>& speeds, std::size_t most,
                                 const MotionLimits& limits, const InterventionProgress& progress);

}  // namespace simgap
