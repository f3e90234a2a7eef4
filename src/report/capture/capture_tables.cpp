#include "capture_tables.h"

#include <fmt/format.h>

#include <cmath>

#include "simgap/measure/capture/capture_run.h"

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
  return table;
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

Table jointTable(const Json& result) {
  Table table{"Joints",
              {"joint", "frames", "range [deg]", "residual [mm]", "centre sd [mm]", "axis sd [deg]", "condition"},
              {}};
  for (const Json& j : result.at("joints")) {
    table.rows.push_back({j.at("name"), j.at("frames").dump(), fixedText(j.at("range_deg"), 1),
                          fixedText(j.at("residual_mm"), 3), fixedText(j.at("centre_sd_mm"), 3),
                          j.contains("axis_sd_deg") ? fixedText(j.at("axis_sd_deg"), 3) : "-",
                          fixedText(j.at("condition"), 3)});
  }
  return table;
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
