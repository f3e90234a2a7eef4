/// \file
/// The result of `capture` as JSON, a table for the terminal and a page.
#pragma once

#include <string>

#include "simgap/measure/capture/capture_run.h"
#include "simgap/report/page.h"

namespace simgap {

Json toJson(const CaptureResult& result, const CaptureStatistics& statistics);
std::string terminalTable(const CaptureResult& result, const CaptureStatistics& statistics);
Page makePage(const CaptureResult& result, const CaptureStatistics& statistics);

}  // namespace simgap
