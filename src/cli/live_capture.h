/// \file
/// Cameras that run, followed on the terminal.
#pragma once

#include <optional>

#include "simgap/capture/capture_run.h"
#include "simgap/capture/live_cameras.h"

namespace simgap {

/// Captures pairs as they come until Ctrl-C, `duration` [s], or the end of a camera, and says once in a while how fast
/// and how late the angles come. Ctrl-C is answered then: what was captured is a complete result.
LiveFigures followCameras(CaptureRun& run, LiveCameras& cameras, const std::optional<double>& duration, bool quiet);

}  // namespace simgap
