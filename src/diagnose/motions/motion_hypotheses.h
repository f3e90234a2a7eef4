/// \file
/// The causes that motions are asked about.
#pragma once

#include <vector>

#include "diagnose/arm_cause.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// Whether it is of a single muscle, as by far the most are.
bool ofOneMuscle(const ArmHypothesis& hypothesis);

/// Every effect that acts while an arm moves, on every target that the model does not have it on already.
/// \param effects  names; empty: all  \param[out] not_testable  those that motions do not show
std::vector<ArmHypothesis> motionHypotheses(const ArmModel& model, const std::vector<std::string>& effects,
                                            std::vector<NotTestable>& not_testable);

/// Whether the catalogue says that it is hard to tell from a cause: of the same muscle or of all, of any joint or body.
bool looksLike(const ArmHypothesis& hypothesis, const ArmCause& cause);

}  // namespace simgap
