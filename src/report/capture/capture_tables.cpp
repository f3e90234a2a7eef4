#include "capture_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/capture/capture_run.h"
#include "simgap/core/error.h"
#include "simgap/core/json_numbers.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

std::string fixedText(const Json& value, int decimals) { return fmt::format("{:.{}f}", numberOf(value), decimals); }

/// "1.23", with a "!" when noise could bridge it; "inf" when there is nothing to confuse it with.
std::string likenessText(const Json& likeness) {
  const Json& rms = likeness.at("rms_mm");
  return (rms.is_null() ? "inf" : fixedText(rms, 2)) + (likeness.at("confused").get<bool>() ? " !" : "");
}

std::string markerText(const Json& markers) {
  std::string text;
  for (const Json& marker : markers) text += (text.empty() ? "" : " ") + marker.dump();
  return text;
}

}  // namespace

std::string captureAnswer(const Json& result, std::size_t poses) {
  const std::size_t doubts = result.at("geometry").at("findings").size();
  return fmt::format("{} pairs: all joints in {:.1f} % of them, {} steady poses; {}", result.at("pairs").dump(),
                     100.0 * numberOf(result.at("pairs_with_all_joints")) / std::max(numberOf(result.at("pairs")), 1.0),
                     poses,
                     doubts == 0 ? "nothing speaks against the geometry."
                                 : fmt::format("the geometry is in doubt for {} reasons.", doubts));
}

Table sightingTable(const Json& result) {
  Table table{"Targets", {"target", "visible %", "markers", "fit RMS [mm]", "ambiguous"}, {}};
  for (const Json& t : result.at("targets")) {
    table.rows.push_back({t.at("name"), fixedText(t.at("visible_percent"), 1),
                          fmt::format("{:.2f} of {}", numberOf(t.at("markers")), t.at("markers_m").size()),
                          fixedText(t.at("rms_mm"), 4), t.at("ambiguous_frames").dump()});
  }
  return table;
}

Table captureFigures(const Json& result) {
  const Json &epipolar = result.at("epipolar_px"), &bar = result.at("scale_bar_mm");
  Table table{"Figures", {"figure", "value"}, {}};
  table.rows = {
      {"standard deviation of a blob's centre [px]", fixedText(result.at("centroid_sd_px"), 4)},
      {"epipolar error, mean and RMS [px]",
       fmt::format("{:+.4f}, {:.4f}", numberOf(epipolar.at("mean")), numberOf(epipolar.at("rms")))},
      {"ghosts per pair", fixedText(result.at("ghosts_per_pair"), 1)},
      {"distances against the target file [%]", fmt::format("{:+.3f}", numberOf(result.at("scale_error_percent")))}};
  if (!bar.is_null()) {
    table.rows.push_back({"scale bar, measured and nominal [mm]",
                          fixedText(bar.at("measured"), 4) + ", " + fixedText(bar.at("nominal"), 4)});
  }
  if (const Json& lag = result.at("camera_lag_ms"); numberOf(lag) != 0.0) {
    table.rows.push_back({"right camera behind left [ms]", fixedText(lag, 3)});
  }
  if (const Json& lag = result.at("shaft_lag_ms"); lag.is_number()) {
    const double correlation = numberOf(result.at("shaft_correlation"));
    table.rows.push_back(
        {"joints behind shafts [ms] (correlation)",
         fmt::format("{} ({:.2f})", correlation > Lag::kClearCorrelation ? fixedText(lag, 1) : "unclear",
                     correlation)});
  }
  if (const Json live = result.value("live", Json(nullptr)); live.is_object()) {
    const auto both = [&](const char* key) {
      return fmt::format("{}, {}", wholeNumber(live.at(key).at(0)), wholeNumber(live.at(key).at(1)));
    };
    const Json& latency = live.at("latency_ms");
    table.rows.push_back({"pairs and poses a second",
                          fixedText(live.at("pairs_per_s"), 1) + ", " + fixedText(live.at("poses_per_s"), 1)});
    table.rows.push_back({"from image to angles, median, 95 %, most [ms]", fixedText(latency.at("median"), 1) + ", " +
                                                                               fixedText(latency.at("p95"), 1) + ", " +
                                                                               fixedText(latency.at("largest"), 1)});
    table.rows.push_back({"frames of left and right camera", both("frames")});
    table.rows.push_back({"dropped, as newer ones came", both("dropped")});
    table.rows.push_back({"without one of the other camera", both("unpaired")});
  }
  return table;
}

/// How far from 0 [deg], of a slide [mm].
std::vector<double> jointAngles(const CsvTable& table, const std::string& joint) {
  if (table.has(joint + "_m")) {
    std::vector<double> ways = numbersOf(table, joint + "_m");
    for (double& way : ways) way *= 1e3;
    return ways;
  }
  const bool revolute = table.has(joint + "_rad");
  std::vector<double> angles = numbersOf(table, joint + (revolute ? "_rad" : "_qw"));
  for (double& angle : angles) angle = toDegrees(revolute ? angle : 2.0 * std::acos(std::min(std::abs(angle), 1.0)));
  return angles;
}

std::string morePoses(std::size_t poses) {
  return fmt::format("The first {} of {} steady poses; all are in poses.csv and result.json.", kMostPosesShown, poses);
}

Table poseTable(const Json& result, const CsvTable& poses) {
  Table table{"Steady poses", {"pose", "from [s]", "to [s]", "samples"}, {}};
  for (const Json& pose : result.at("poses")) {
    table.rows.push_back(
        {pose.at("pose"), fixedText(pose.at("start_s"), 3), fixedText(pose.at("end_s"), 3), pose.at("samples").dump()});
  }
  for (const auto& [joint, type] : result.at("joint_types").items()) {
    const std::string unit = type == "prismatic" ? "mm" : "deg";
    table.header.insert(table.header.end(), {fmt::format("{} [{}]", joint, unit), "spread"});
    const std::vector<double> angles = jointAngles(poses, joint);
    for (std::size_t p = 0; p < table.rows.size(); ++p) {
      const Json& spread = result.at("poses").at(p).at("spread_" + unit).at(joint);
      table.rows[p].insert(table.rows[p].end(), {fmt::format("{:.2f}", angles.at(p)), fixedText(spread, 3)});
    }
  }
  return table;
}

std::string cameraAnswer(const Json& result) {
  const Json& parameters = result.at("parameters");
  const Json& baseline = parameters.at(parameters.size() - 1);  // back() of nothing is undefined
  return fmt::format(
      "Views that were held out are met within {:.3f} px ({:.3f} px on the views used); baseline {:.3f} mm ± {:.3f}.",
      numberOf(result.at("heldout_rms_px")), numberOf(result.at("rms_px")), numberOf(baseline.at("value")),
      numberOf(baseline.at("sd")));
}

Table cameraFigures(const Json& result) {
  const Json &coverage = result.at("coverage"), &bar = result.at("scale_bar");
  Table table{"Figures", {"figure", "value"}, {}};
  table.rows = {
      {"pairs looked at, with the board, left out",
       fmt::format("{}, {}, {}", result.at("pairs").dump(), result.at("views").size(), result.at("outliers").dump())},
      {"reprojection error, views used [px]", fixedText(result.at("rms_px"), 4)},
      {"reprojection error, views held out [px]", fixedText(result.at("heldout_rms_px"), 4)},
      {"image covered by corners, left and right [%]",
       fmt::format("{:.0f}, {:.0f}", 100.0 * numberOf(coverage.at("left")), 100.0 * numberOf(coverage.at("right")))}};
  if (bar.is_null()) {
    table.rows.push_back({"scale bar", "none: the scale is that of the board"});
  } else {
    table.rows.push_back(
        {"scale bar, measured and nominal [mm]",
         fmt::format("{} +- {}, {} ({:+.3f} %)", fixedText(bar.at("measured_mm"), 4), fixedText(bar.at("sd_mm"), 4),
                     fixedText(bar.at("nominal_mm"), 4), numberOf(bar.at("error_percent")))});
  }
  return table;
}

Table cameraParameters(const Json& result) {
  Table table{"Parameters (sd: jackknife over the held-out groups)", {"parameter", "value", "sd", "unit"}, {}};
  for (const Json& p : result.at("parameters")) {
    table.rows.push_back({p.at("name"), fmt::format("{:.5g}", numberOf(p.at("value"))),
                          fmt::format("{:.2g}", numberOf(p.at("sd"))), p.at("unit")});
  }
  return table;
}

std::string jointAnswer(const Json& result) {
  std::string answer;
  for (const Json& j : result.at("joints")) {
    const std::string name = j.at("name");
    answer += j.contains("axis_sd_deg")
                  ? fmt::format("{} axis within {:.2f}°, ", name, numberOf(j.at("axis_sd_deg")))
                  : fmt::format("{} centre within {:.2f} mm, ", name, numberOf(j.at("centre_sd_mm")));
  }
  if (answer.empty()) throw DataError("result.json: joints: found none, expected at least one");
  answer = capitalised(std::move(answer));
  for (const Json& bone : result.at("bones")) {
    answer += fmt::format("{} to {} {:.1f} mm, ", bone.at("from").get<std::string>(), bone.at("to").get<std::string>(),
                          numberOf(bone.at("length_mm")));
  }
  answer.resize(answer.size() - 2);
  return answer + fmt::format("; the zero pose is that of the {}.",
                              result.at("zero_pose_from_frames").get<bool>() ? "frames named" : "target file");
}

Table jointTable(const Json& result) {
  Table table{
      "Joints", {"joint", "frames", "range", "residual [mm]", "centre sd [mm]", "axis sd [deg]", "condition"}, {}};
  for (const Json& j : result.at("joints")) {
    table.rows.push_back(
        {j.at("name"), j.at("frames").dump(),
         j.contains("range_mm") ? fixedText(j.at("range_mm"), 1) + " mm" : fixedText(j.at("range_deg"), 1) + " deg",
         fixedText(j.at("residual_mm"), 3), fixedText(j.at("centre_sd_mm"), 3),
         j.contains("axis_sd_deg") ? fixedText(j.at("axis_sd_deg"), 3) : "-", fixedText(j.at("condition"), 3)});
  }
  return table;
}

std::string targetAnswer(const Json& result) {
  return fmt::format("Whole targets {} be confused at a noise of {:.2f} mm per marker ('!': it could bridge the gap).",
                     result.at("sound").get<bool>() ? "cannot" : "CAN", numberOf(result.at("noise_mm")));
}

Table targetTable(const Json& result) {
  Table table{"Each target [mm]",
              {"target", "smallest gap", "from its plane", "other order", "mirror image", "3 markers for 3 others"},
              {}};
  for (const Json& t : result.at("targets")) {
    table.rows.push_back({t.at("name"), fixedText(t.at("smallest_gap_mm"), 2), fixedText(t.at("from_plane_mm"), 2),
                          likenessText(t.at("symmetry")), likenessText(t.at("mirror")), likenessText(t.at("triple"))});
  }
  return table;
}

Table crossTable(const Json& result) {
  Table table{"Targets against each other [mm]", {"taken for one another", "whole", "3 markers", "these 3"}, {}};
  for (std::size_t i = 0; i < result.at("cross").size(); ++i) {
    const Json& triple = result.at("cross_triples").at(i);
    table.rows.push_back({triple.at("from").get<std::string>() + " / " + triple.at("to").get<std::string>(),
                          likenessText(result.at("cross").at(i)), likenessText(triple),
                          markerText(triple.at("markers")) + " / " + markerText(triple.at("taken_for"))});
  }
  return table;
}

}  // namespace simgap
