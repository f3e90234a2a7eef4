/// \file
/// Which causes of the catalogue a log and a model can be asked for.
#pragma once

#include "log_hypotheses.h"

namespace simgap {

/// Every wanted cause that applies to the subject; what the log cannot show is told in `diagnosis`.
std::vector<Hypothesis> namedHypotheses(const ActuatorModel& subject, const ActuatorData& data,
                                        const LogDiagnosisOptions& options, Diagnosis& diagnosis);

}  // namespace simgap
