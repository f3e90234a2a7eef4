/// \file
/// The result of `capture` as JSON, tables and a table for the terminal.
#pragma once

#include <string>

#include "simgap/capture/capture_run.h"
#include "simgap/core/run_directory.h"

namespace simgap {

Json toJson(const CaptureResult& result, const CaptureStatistics& statistics);
std::string terminalTable(const CaptureResult& result, const CaptureStatistics& statistics);

}  // namespace simgap
