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

/// One motion that may be recorded.
struct MotionProtocol {
  PlannedMotion motion;  ///< one that was recorded, in another time
  double speed = 1.0;    ///< so many times as fast
  ForeseenChange foreseen = {};
  int chosen = 0;  ///< its place among those to record, from 1; 0: not one of them
};

struct MotionSeparation {
  std::vector<MotionProtocol> protocols;
  std::vector<double> smallest;  ///< shape (chosen): log odds of the worst pair after 1, 2 … of them
};

/// \param speeds  > 0 \param most  to choose at most
/// \throws ConfigError: no candidate contradicts the named one. NumericsError: it cannot play one. InterruptedError
MotionSeparation separateMotions(const MotionEvidence& evidence, const std::vector<double>& speeds, std::size_t most,
                                 const InterventionProgress& progress);

}  // namespace simgap
