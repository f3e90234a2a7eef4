/// \file
/// What `simulate` shows and writes of a leg in an exoskeleton (002 fig. 14 and 15).
#pragma once

#include <string>

#include "simgap/report/table.h"
#include "simgap/simulate/exo_leg_motion.h"

namespace simgap {

Json toJson(const ExoLeg& leg, const ExoLegStudy& study);
/// The answer in a sentence, from the result's JSON.
std::string exoLegAnswer(const Json& result);
/// A row with the exoskeleton, one without, from the result's JSON.
Table exoLegTable(const Json& result);
std::string exoLegText(const Json& result);

/// motion.csv: with the exoskeleton, and the hip's height without. \param rate  of the rows [Hz]
void writeExoLeg(const ExoLeg& leg, const ExoLegStudy& study, double rate, const RunDirectory& directory);

}  // namespace simgap
