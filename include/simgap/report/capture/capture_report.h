/// \file
/// The result of `capture` as JSON, tables and a table for the terminal.
#pragma once

#include <string>

#include "simgap/capture/capture_run.h"
#include "simgap/core/json_pieces.h"

namespace simgap {

/// Without the poses, which can be many: "poses" is an empty list.
Json toJson(const CaptureResult& result, const CaptureStatistics& statistics);
/// Those poses. \param result  has to outlive it
LongList posesOf(const CaptureResult& result);
std::string terminalTable(const CaptureResult& result, const CaptureStatistics& statistics);

}  // namespace simgap
