/// \file
/// How far a verdict on this very log can be trusted: every testable effect, and none, is hidden in what the model
/// predicts for the log's own motion and loads, under the log's own noise, and diagnosed again.
#pragma once

#include "log_selection.h"

namespace simgap {

/// \param fitted  the model that the log led to, on all rows.  \param detectable  gives the magnitudes: each effect is
/// hidden at a gain of some 8 %.
SelfTest runSelfTest(const ActuatorModel& subject, const PreparedLog& log, const Fitted& fitted,
                     const std::vector<Hypothesis>& named, const std::vector<Hypothesis>& unnamed,
                     const std::vector<Detectable>& detectable, double effective_samples,
                     const LogDiagnosisOptions& options, const std::vector<Block>& training,
                     const DiagnosisProgress& progress);

}  // namespace simgap
