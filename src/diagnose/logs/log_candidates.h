/// \file
/// Which models of a log are worth asking about a change: the named one, those in which another cause stands in the
/// place of a named one, those with a cause that was refused, and the one without causes.
#pragma once

#include <vector>

#include "log_selection.h"

namespace simgap {

/// \param refused  causes that were accepted and taken out again. \param hypotheses  all that were tried. \param own
/// effects of the baseline. \param correlation  [rows] of the named model's residuals.
/// \returns the named one first; alone where nothing can be set against it
std::vector<FittedLogCandidate> logCandidates(const LogSearch& search, const PreparedLog& log,
                                              const Selection& selection, const std::vector<Candidate>& refused,
                                              const std::vector<Hypothesis>& hypotheses, std::size_t own,
                                              double correlation);

/// Degrees of freedom with which pieces of a log know a mean squared error that changes from piece to piece
/// (Satterthwaite 1946), neighbours that are alike counted once; at least 1.
double freedomOf(const GroupErrors& errors);

}  // namespace simgap
