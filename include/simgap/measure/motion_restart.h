/// \file
/// Long motions begin anew from measured states.
///
/// A whole rollout of a long motion may run away from the recorded one, and says nothing of what comes after. Cut into
/// pieces, each begins where joints and shafts were measured, 0.5 s before the piece before it ends: what is wrong with
/// a start that has noise is forgotten within this run-up, which is played and not compared.
#pragma once

#include "simgap/measure/motion_set.h"

namespace simgap {

inline constexpr double kShortestRestart = 1.0;  ///< [s]

/// The same motions, those longer than 1.5 `every` in pieces of about `every` [s], "name @ 10 s" for all but the first.
/// \throws DataError: a motion has voltages or forces for commands and measures no shafts, or too few frames to tell
/// where it is to begin again
MotionSet restarted(const MotionSet& set, const PoseLayout& layout, double every);

}  // namespace simgap
