/// \file
/// The result of `calibrate-cameras` as JSON and a table for the terminal.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/capture/camera_calibration.h"
#include "simgap/capture/capture_statistics.h"
#include "simgap/core/run_directory.h"

namespace simgap {

/// A bar of known length seen by the calibrated cameras.
struct ScaleBarCheck {
  double nominal = 0.0;        ///< [m]
  RunningStatistics measured;  ///< [m]
  std::size_t pairs = 0;       ///< looked at
  double errorPercent() const { return 100.0 * (measured.mean() / nominal - 1.0); }
};

struct CameraCalibrationResult {
  CameraCalibration calibration;
  std::vector<BoardView> views;
  std::size_t pairs = 0;  ///< looked at
  std::optional<ScaleBarCheck> scale_bar;
};

Json toJson(const CameraCalibrationResult& result);
std::string terminalTable(const CameraCalibrationResult& result);

}  // namespace simgap
