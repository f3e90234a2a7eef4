/// \file
/// Stamps that jitter while the samples do not. A bus master or a driver samples evenly, and the computer that logs it
/// stamps each row when it comes to it: read at such times a smooth motion trembles by its speed times the jitter, and
/// its derivatives are noise. Whether the stamps or even times are the true ones is for the motion to say.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "simgap/core/blocks.h"

namespace simgap {

struct EvenTimes {
  std::vector<double> time;  ///< [s] of the samples, rising, shape (n)
  double jitter = 0.0;       ///< [s] of the stamps about them, a standard deviation
  double times_smoother = 1.0;
};

/// The usual time from one row to the next, an upper median [s]; 0 of fewer than two rows.
/// \param time  [s] rising, shape (n)
double usualStep(std::span<const double> time);

/// Even times beside the stamps (their slow drift, and samples that were lost, are kept), if the channel is clearly
/// smoother over them: by the third divided differences of its fast half. None where stamps do not jitter, where the
/// samples jitter with them, and where rounding off hides the difference.
/// \param time  [s] rising within runs, \param values  the channel that is differentiated, both shape (n).
/// \param runs  that may be smoothed (splitRuns).
std::optional<EvenTimes> evenTimes(std::span<const double> time, std::span<const double> values,
                                   std::span<const Block> runs);

}  // namespace simgap
