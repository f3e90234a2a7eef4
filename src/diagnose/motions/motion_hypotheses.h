/// \file
/// The causes that motions are asked about.
#pragma once

#include <vector>

#include "diagnose/arm_cause.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

struct MotionHypothesis {
  const ArmEffect* effect = nullptr;
  std::string target;
  std::vector<EffectParameters> starts;  ///< where fits of it begin, the first where it is most easily seen
};

/// By far the most are.
bool ofOneMuscle(const MotionHypothesis& hypothesis);

/// Where fits of an effect begin, with those of its choices that the target has: a muscle that crosses one joint cannot
/// bend round a second.
std::vector<EffectParameters> possibleStarts(const ArmEffect& effect, const std::string& target, const ArmModel& model);

/// Every effect that acts while an arm moves, on every target that the model does not have it on already.
/// \param effects  names; empty: all  \param[out] not_testable  those that motions do not show
std::vector<MotionHypothesis> motionHypotheses(const ArmModel& model, const std::vector<std::string>& effects,
                                               std::vector<NotTestable>& not_testable);

/// Whether the catalogue says that it is hard to tell from a cause: of the same muscle or of all, of any joint or body.
bool looksLike(const MotionHypothesis& hypothesis, const ArmCause& cause);

}  // namespace simgap
