/// \file
/// Rows of a drive's log that mean nothing to a kinetic law: samples that stand alone, rests, a motor that is off.
#pragma once

#include <span>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/measure/logs/friction_rows.h"
#include "simgap/measure/logs/motion.h"

namespace simgap {

/// Where stamps jitter and the samples of what is differentiated do not, time becomes even, which `data` says.
/// \param acceleration  is needed, too: a velocity is differentiated as well.
void takeEvenTimes(ActuatorLog& log, std::span<const Block> runs, bool acceleration, FrictionData& data);

/// A velocity that is late against the position beside it is moved to where the position has its slope.
void moveLateVelocity(ActuatorLog& log, std::span<const Block> runs, FrictionData& data);

/// A velocity that says what the position beside it does, but far noisier, gives way to what is worked out from there.
void replaceNoisyVelocity(ActuatorLog& log, std::span<const Block> runs, FrictionData& data);

/// Samples that stand alone are noted in `data` for every channel, and put right.
void putSpikesRight(ActuatorLog& log, FrictionData& data);

/// Takes the rows of spikes, and of rests, out of `sign.keep`, and says so in `data`.
/// \param blurred_seconds  beside a rest, of a motion that was worked out; 0: it was measured.
/// \param sticks_shortly  a rest may last two rows only: an encoder that stands is no noise, a measured velocity within
/// its noise may pass through zero.
/// \throws DataError: with FrictionDataOptions::all_rows, hardly any motion.
void leaveOutSpikes(const FrictionDataOptions& options, MotionSign& sign, FrictionData& data);
/// The same of sessions, or rows between gaps, that are too short for a slope, where slopes were worked out.
void leaveOutShortRuns(std::span<const Block> runs, MotionSign& sign, FrictionData& data);
void leaveOutRests(const ActuatorLog& log, double blurred_seconds, bool sticks_shortly,
                   const FrictionDataOptions& options, MotionSign& sign, FrictionData& data);

/// Takes the rows out of `sign.keep` in which a motor that is driven by a voltage is switched off while it moves, and
/// says so in `data`: its open terminals carry no current, whatever its speed, and the zero of the log is no voltage.
void leaveOutSwitchedOff(const ActuatorLog& log, const FrictionDataOptions& options, MotionSign& sign,
                         FrictionData& data);

}  // namespace simgap
