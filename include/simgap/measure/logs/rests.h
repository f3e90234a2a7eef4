/// \file
/// When a drive stands still. There its effort is whatever a holding controller left between load - tau_s and
/// load + tau_s: such a row says nothing about friction in motion.
#pragma once

#include <span>
#include <vector>

namespace simgap {

/// Rows of rests: runs within a session in which |velocity| stays within `slow` for `least_seconds` and longer.
/// Reversals pass through there faster. A drive that creeps while it is held rests, too.
/// \param time  [s], \param velocity  shape (n).  \param slow  [velocity's unit]
std::vector<bool> findRests(std::span<const double> time, std::span<const double> velocity,
                            std::span<const int> session, double slow, double least_seconds = 0.3);

/// Speed below which a drive counts as resting: its dead band, or a small share of its usual speed, because held drives
/// creep.
double restingSpeed(std::span<const double> velocity, double dead_band);

}  // namespace simgap
