/// \file
/// A pneumatic muscle with and without its tendon's spring, fitted to the same rows and judged on others (002 III).
#pragma once

#include <optional>

#include "simgap/fit/actuators/fit_comparison.h"
#include "simgap/fit/actuators/pam_fit.h"

namespace simgap {

using PamCandidate = FitCandidate<PamFit>;
/// One candidate when the spring is known, else no-spring and spring; the best has the lowest held-out error, of all
/// rows where none are held out.
using PamComparison = FitComparison<PamFit>;

/// \param options  its `spring` is not used. \param maker  fit to the maker's curves: its a, b, c are taken as known.
/// \param holdout  kept from the fits; without one a fifth of five or more blocks judges, and the final fit has all
///        rows. \param block_s  length of the blocks [s]; empty: as blockSeconds
/// \throws DataError as fitPam and fittedRows.
PamComparison comparePam(const PamLog& log, const PamFitOptions& options, const std::optional<PamFit>& maker,
                         const Holdout& holdout, const std::optional<double>& block_s);

}  // namespace simgap
