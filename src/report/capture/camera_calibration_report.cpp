#include "simgap/report/capture/camera_calibration_report.h"
#include "simgap/report/text_table.h"

#include <fmt/format.h>


namespace simgap {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string answer(const CameraCalibrationResult& result) {
  const CameraCalibration& c = result.calibration;
  return fmt::format(
      "Views that were held out are met within {:.3f} px ({:.3f} px on the views used); baseline {:.3f} "
      "mm +- {:.3f}.",
      c.heldout_rms, c.rms, c.numbers.back().value, c.numbers.back().sd);
}

Rows figureRows(const CameraCalibrationResult& result) {
  const CameraCalibration& c = result.calibration;
  Rows rows{{"pairs looked at, with the board, left out",
             fmt::format("{}, {}, {}", result.pairs, result.views.size(), c.outliers.size())},
            {"reprojection error, views used [px]", fmt::format("{:.4f}", c.rms)},
            {"reprojection error, views held out [px]", fmt::format("{:.4f}", c.heldout_rms)},
            {"image covered by corners, left and right [%]",
             fmt::format("{:.0f}, {:.0f}", 100.0 * c.left_coverage, 100.0 * c.right_coverage)}};
  if (result.scale_bar) {
    const ScaleBarCheck& bar = *result.scale_bar;
    rows.push_back({"scale bar, measured and nominal [mm]",
                    fmt::format("{:.4f} +- {:.4f}, {:.4f} ({:+.3f} %)", 1e3 * bar.measured.mean(),
                                1e3 * bar.measured.sd(), 1e3 * bar.nominal, bar.errorPercent())});
  } else {
    rows.push_back({"scale bar", "none: the scale is that of the board"});
  }
  return rows;
}

const std::vector<std::string> kNumberHeader = {"parameter", "value", "sd", "unit"};

Rows numberRows(const CameraCalibration& c) {
  Rows rows;
  for (const CalibratedNumber& n : c.numbers) {
    rows.push_back({n.name, fmt::format("{:.5g}", n.value), fmt::format("{:.2g}", n.sd), n.unit});
  }
  return rows;
}

}  // namespace

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
  Rows numbers = numberRows(result.calibration);
  numbers.insert(numbers.begin(), kNumberHeader);
  return answer(result) + "\n\n" + alignedTable(figureRows(result)) + "\n" + alignedTable(numbers);
}

}  // namespace simgap
