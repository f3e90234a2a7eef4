#include "simgap/report/capture/camera_calibration_report.h"

#include "capture_tables.h"

namespace simgap {
Json toJson(const CameraCalibrationResult& result) {
  const CameraCalibration& c = result.calibration;
  Json parameters = Json::array();
  for (const CalibratedNumber& n : c.numbers) {
    parameters.push_back({{"name", n.name}, {"unit", n.unit}, {"value", n.value}, {"sd", n.sd}});
  }
  Json views = Json::array();
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    views.push_back({{"name", result.views[v].name}, {"rms_px", numberOrNull(c.view_rms[v])}});
  }
  Json bar = nullptr;
  if (result.scale_bar) {
    bar = {{"nominal_mm", 1e3 * result.scale_bar->nominal},
           {"measured_mm", 1e3 * result.scale_bar->measured.mean()},
           {"sd_mm", 1e3 * result.scale_bar->measured.sd()},
           {"pairs", result.scale_bar->measured.count()},
           {"error_percent", result.scale_bar->errorPercent()}};
  }
  return {{"format", "simgap/calibrate-cameras/1"},
          {"pairs", result.pairs},
          {"views", views},
          {"outliers", c.outliers.size()},
          {"rms_px", c.rms},
          {"heldout_rms_px", c.heldout_rms},
          {"coverage", {{"left", c.left_coverage}, {"right", c.right_coverage}}},
          {"parameters", parameters},
          {"scale_bar", bar}};
}

std::string terminalTable(const CameraCalibrationResult& result) {
  const Json json = toJson(result);
  return cameraAnswer(json) + "\n\n" + alignedTable(cameraFigures(json).rows) + "\n" +
         alignedTable(cameraParameters(json));
}

}  // namespace simgap
