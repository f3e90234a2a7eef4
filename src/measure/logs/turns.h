/// \file
/// Where a joint turns back. Until friction has built up the other way it is presliding, of which no law of kinetic
/// friction knows, and smoothing mixes both sides of a turn: a turn is a rest of no length.
#pragma once

#include <span>
#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/robot_log.h"

namespace simgap {

/// First rows of a new direction within runs. \param direction  shape (n)
std::vector<std::size_t> turnsOf(std::span<const signed char> direction, std::span<const Block> runs);

/// Takes the rows beside turns and the ends of runs out of `sign.keep` that a smoother has blurred, on both sides; at
/// least half of the rows that it kept stay. \param runs  none empty \param time  [s], shape (n) \param blurred_seconds
/// on either side
void leaveOutTurns(std::span<const double> time, std::span<const Block> runs, double blurred_seconds, MotionSign& sign);

/// A joint's channels as they were logged, shape (n) each: position [rad], effort in any unit.
struct TurningJoint {
  std::span<const double> time, position, effort;
};

/// Travel after a turn [rad] over which friction builds up: around every turn the effort is a polynomial of time, which
/// the load is for so short a while, and from the turn on A (1 - exp(-x / x_s)) in the new direction more, of travel x
/// since the turn (Dahl 1968), with one A and one x_s for all turns. 0 where friction that is there at once explains
/// the turns clearly better than such that takes long; where nothing is clear the likeliest travel, kUntold at least.
/// \param seconds  before and after a turn
double travelOfFriction(const TurningJoint& joint, std::span<const std::size_t> turns, std::span<const Block> runs,
                        const MotionSign& sign, double seconds);

/// Takes rows out of `sign.keep` until that much travel [rad] has passed since a turn, a rest or the beginning of a
/// run; at least half of the rows that it kept stay. \param slow  [rad/s]: a joint that is not faster rests
void leaveOutFirstTravel(std::span<const double> position, std::span<const double> velocity,
                         std::span<const Block> runs, double slow, double travel, MotionSign& sign);

}  // namespace simgap
