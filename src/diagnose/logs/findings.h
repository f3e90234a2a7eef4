/// \file
/// What counts as a finding. A cause that a search accepted may still be a fit and no cause: its parameters are not
/// determined or stand at a bound, its gain on held-out data may be nothing, or anything of its colour would have done
/// as well. Such a cause is a candidate: it is shown below the line and is in no model.
#pragma once

#include "held_out.h"
#include "log_causes.h"

namespace simgap {

/// Takes causes that are no findings out of the selection, the last accepted first, until every cause left is one.
/// \param own  effects of the baseline, which stay.  \returns those taken out, with the reason.
std::vector<Candidate> keepFindings(const LogSearch& search, const PreparedLog& log, const LogSplit& split,
                                    std::size_t own, const LogDiagnosisOptions& options, Selection& selection);

}  // namespace simgap
