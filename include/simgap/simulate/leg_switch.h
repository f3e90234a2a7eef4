/// \file
/// A switch of two states over time, as a decoder leaves it (002 eq. 9): what a leg, or a joint, is told.
#pragma once

#include <vector>

#include "simgap/core/csv.h"

namespace simgap {

/// When it is to be up: the state from each time on.
struct LegSwitch {
  std::vector<double> times;  ///< [s], rising
  std::vector<bool> up;
};
/// `time_s` and `state` (`up`, `down`; `none` keeps what was, at first down), as `decode run` leaves them in
/// decoded.csv. \throws DataError: no rows, times that do not rise, another word
LegSwitch readLegSwitch(const CsvTable& table);

}  // namespace simgap
