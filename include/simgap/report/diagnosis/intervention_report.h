/// \file
/// The result of `intervene` as JSON, tables and text.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/intervene/poses/pose_intervention.h"

namespace simgap {

Json toJson(const Intervention& result, const PoseEvidence& evidence, const ArmChanges& change);
/// Rows: pose and joint; columns: the error of every candidate [deg], of a slide [mm].
std::string predictionsCsv(const Intervention& result, const PoseEvidence& evidence, const PoseSet& after);

/// \param changes  shape (foreseen)
Json toJson(const std::vector<ForeseenChange>& foreseen, const PoseEvidence& evidence,
            const std::vector<ArmChanges>& changes);

/// Of either result.
std::string interventionText(const Json& result);

}  // namespace simgap
