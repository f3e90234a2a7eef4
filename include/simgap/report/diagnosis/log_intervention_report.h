/// \file
/// The result of `intervene` on a log as JSON and tables; text as of intervention_report.h.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/intervene/logs/log_intervention.h"

namespace simgap {

Json toJson(const LogIntervention& result, const LogEvidence& evidence, const LogChanges& change);
/// Rows: time, what was measured and what every candidate predicted.
std::string predictionsCsv(const LogIntervention& result, const LogEvidence& evidence);

/// \param changes  shape (foreseen)
Json toJson(const std::vector<ForeseenLogChange>& foreseen, const LogEvidence& evidence,
            const std::vector<LogChanges>& changes);
/// What every candidate predicts for the reference log after one of the changes.
std::string predictionsCsv(const ForeseenLogChange& foreseen, const LogEvidence& evidence);
/// The change of a list that tells most. \param foreseen  not empty
std::size_t bestOf(const std::vector<ForeseenLogChange>& foreseen);

}  // namespace simgap
