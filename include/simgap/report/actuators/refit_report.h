/// \file
/// The report of `fit-* --model FILE`: law and extensions of a diagnosed model, fitted together to a log.
#pragma once

#include <string>

#include "simgap/diagnose/logs/refitted_model.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {

/// \param command  "fit-friction". \param model  the refitted one
FitSummary summarise(const std::string& command, const PreparedLog& log, const FittedModel& model,
                     const LogRefit& refit);

/// model.yaml, predictions.csv and parameters.csv.
void writeRefit(const FitSummary& summary, const PreparedLog& log, const FittedModel& model, const LogRefit& refit,
                const RunDirectory& directory);

}  // namespace simgap
