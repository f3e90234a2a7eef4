/// \file
/// When a drive stands still. There its effort is whatever a holding controller left between load - tau_s and
/// load + tau_s: such a row says nothing about friction in motion.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace simgap {

struct RestRule {
  double slow;                  ///< [velocity's unit] no rest is faster
  double least_seconds = 0.3;   ///< reversals pass through zero faster
  std::size_t fewest_rows = 4;  ///< likewise
  /// A velocity worked out from smoothed positions begins that much before the drive does, and ends that much after it.
  double blurred_seconds = 0.0;
};

/// Rows of rests: runs within a session in which |velocity| stays within `slow`, and the rows beside them that a
/// smoother has blurred. A drive that creeps while it is held rests, too.
/// \param time  [s], \param velocity  shape (n).
std::vector<bool> findRests(std::span<const double> time, std::span<const double> velocity,
                            std::span<const int> session, const RestRule& rule);

/// Of the fastest twentieth of the rows: a single one may be a spike. 0 of none.
double fastSpeed(std::span<const double> velocity);

/// Speed below which a drive counts as resting: its dead band, or a small share of its usual speed, because held drives
/// creep.
double restingSpeed(std::span<const double> velocity, double dead_band);

}  // namespace simgap
