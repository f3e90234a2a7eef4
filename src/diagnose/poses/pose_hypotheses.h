/// \file
/// What may be wrong with an arm that was recorded in poses: every effect of the catalogue on every target that it has.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "diagnose/arm_cause.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"

namespace simgap {

/// All hypotheses that the poses can test, and why others cannot be.
std::vector<ArmHypothesis> poseHypotheses(const ArmModel& model, std::span<const Pose> poses,
                                          const std::vector<std::string>& effects,
                                          std::vector<NotTestable>& not_testable);

/// The share of all hypotheses that one has before any data: every effect is as likely as any other, and so is each of
/// its targets and moments; an effect on all muscles is as likely as on some one of them.
double shareOf(const ArmHypothesis& hypothesis, std::span<const ArmHypothesis> all, std::size_t poses);

}  // namespace simgap
