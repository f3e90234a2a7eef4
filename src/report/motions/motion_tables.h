/// \file
/// Pieces that the reports and pages on motions share; made from result.json.
#pragma once

#include "simgap/report/html/page.h"
#include "simgap/report/html/result_files.h"
#include "simgap/report/motions/motion_report.h"

namespace simgap {

/// {<joint>_deg (of a slide _mm), shafts_deg, currents_A}; null where nothing was measured
Json rmsJson(const MotionRms& rms, const PoseLayout& layout);
/// Root mean squares of channel groups beside their noise. \param rows  name -> rmsJson
Table rmsTable(const std::string& caption, const std::vector<std::pair<std::string, Json>>& rows);
/// Of calibrate: sets before and after, what was predicted, noise.
Table calibrationRms(const Json& result);
/// Of validate: per motion and over all.
Table validationRms(const Json& result);
/// The channels with the worst second, worst first.
Table worstChannels(const Json& result);
/// Errors over time of residuals.csv, one chart per motion.
void addResidualCharts(const ResultFiles& files, Page& page);

}  // namespace simgap
