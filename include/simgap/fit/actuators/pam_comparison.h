/// \file
/// A pneumatic muscle with and without its tendon's spring, fitted to the same rows and judged on others (002 III).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/holdout.h"
#include "simgap/fit/actuators/pam_fit.h"

namespace simgap {

struct PamCandidate {
  std::string name;  ///< "spring" or "no-spring"
  PamFit fit;
  std::optional<double> mse_heldout;  ///< [N^2]
};

struct PamComparison {
  std::vector<PamCandidate> candidates;  ///< one when the spring is known, else no-spring, spring
  std::size_t best = 0;                  ///< the lowest held-out error (of all rows where none are held out)
  std::string heldout;                   ///< which rows, in words
  const PamCandidate& chosen() const { return candidates[best]; }
};

/// \param options  its `spring` is not used. \param maker  fit to the maker's curves: its a, b, c are taken as known.
/// \param holdout  kept from the fits; without one a fifth of five or more blocks judges, and the final fit has all
///        rows. \param block_s  length of the blocks [s]; empty: as blockSeconds
/// \throws DataError as fitPam and heldOutRows.
PamComparison comparePam(const PamLog& log, const PamFitOptions& options, const std::optional<PamFit>& maker,
                         const Holdout& holdout, const std::optional<double>& block_s);

}  // namespace simgap
