/// \file
/// What counts as a finding. A cause that a search accepted may still be a fit and no cause: its parameters are not
/// determined or stand at a bound, its gain on held-out data may be nothing, or anything of its colour would have done
/// as well. Such a cause is a candidate: it is shown below the line and is in no model.
#pragma once

#include <optional>

#include "held_out_parts.h"
#include "log_causes.h"
#include "log_evidence.h"

namespace simgap {

struct Findings {
  std::vector<Candidate> candidates;  ///< taken out, with the reason
  std::vector<GroupErrors> heldout;   ///< errors of each step that is left, on the held-out blocks
  Fitted on_all_rows;                 ///< the model with the causes that are left
  LogFit fit;                         ///< it
  std::optional<Ceiling> left;        ///< what forests still explain; none where there is no cause
};

/// Takes causes that are no findings out of the selection, the last accepted first, until every cause left is one.
/// \param own  effects of the baseline, which stay. \param hypotheses  rivals of what is left, named
Findings keepFindings(const LogSearch& search, const PreparedLog& log, HeldOutParts& parts, std::size_t own,
                      const std::vector<Hypothesis>& hypotheses, const LogDiagnosisOptions& options,
                      Selection& selection);

}  // namespace simgap
