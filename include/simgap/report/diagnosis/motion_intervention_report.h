/// \file
/// The result of `intervene` on motions as JSON and a table; text as of intervention_report.h.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/intervene/motions/motion_intervention.h"

namespace simgap {

Json toJson(const MotionIntervention& result, const MotionEvidence& evidence, const ArmChanges& change,
            const MotionSet& after);
/// Rows: motion and channel; columns: root mean square errors of every candidate [sd of the noise].
std::string predictionsCsv(const MotionIntervention& result, const MotionEvidence& evidence, const MotionSet& after);

/// \param changes  shape (foreseen)
Json toJson(const std::vector<ForeseenChange>& foreseen, const MotionEvidence& evidence,
            const std::vector<ArmChanges>& changes);

}  // namespace simgap
