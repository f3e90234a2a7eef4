/// \file
/// The result of `capture` as JSON, tables and a table for the terminal.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/measure/capture/capture_run.h"

namespace simgap {

Json toJson(const CaptureResult& result, const CaptureStatistics& statistics);
/// Distances of the markers of each target: nominal, measured, and the spread that the noise of the blobs predicts.
std::string distancesCsv(const CaptureResult& result, const CaptureStatistics& statistics);
/// How many distances are off by how much.
std::string histogramCsv(const CaptureStatistics& statistics);
std::string terminalTable(const CaptureResult& result, const CaptureStatistics& statistics);

}  // namespace simgap
