/// \file
/// What a selection on a log is worth: the models fitted to all rows, the causes with their gain on held-out blocks,
/// and what could have been found.
#pragma once

#include "log_selection.h"

namespace simgap {

/// A model fitted to all rows; `fitted` is moved there.
LogFit describe(const LogSearch& search, const PreparedLog& log, Fitted& fitted);
/// The same, with the covariance of theta, shape (P, P).
std::pair<LogFit, Eigen::MatrixXd> describeFully(const LogSearch& search, const PreparedLog& log, Fitted& fitted);

/// \param heldout  errors of each step of the selection; \param own  number of effects the model had before; \param
/// baseline, extended  fitted to all rows.
std::vector<Cause> causesOf(const Selection& selection, const std::vector<GroupErrors>& heldout, const LogFit& baseline,
                            const LogFit& extended, std::size_t own, std::uint64_t seed);

/// The smallest magnitude that would have been found: large enough against its own uncertainty (a z of 3 for the number
/// of hypotheses, 1.6 for 95 % power), and against the least gain. A cause that would have to change more than the
/// effort itself is not testable.
void addDetectable(const LogSearch& search, const std::vector<Trial>& trials, double least_gain,
                   double effective_samples, Diagnosis& d);

}  // namespace simgap
