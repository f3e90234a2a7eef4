#include "simgap/report/capture_report.h"

#include <fmt/format.h>

#include "pose_tables.h"

namespace simgap {
namespace {

double percent(std::size_t part, std::size_t all) {
  return all > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(all) : 0.0;
}

using Rows = std::vector<std::vector<std::string>>;

const std::vector<std::string> kTargetHeader = {"target", "visible %", "markers", "fit RMS [mm]", "ambiguous"};

Rows targetRows(const CaptureResult& result, const CaptureStatistics& s) {
  Rows rows;
  for (std::size_t t = 0; t < result.targets.targets.size(); ++t) {
    const MarkerTarget& target = result.targets.targets[t];
    rows.push_back({target.name, fmt::format("{:.1f}", percent(s.found(t), s.frames())),
                    fmt::format("{:.2f} of {}", s.markers(t).mean(), target.markers.size()),
                    fmt::format("{:.4f}", 1e3 * s.rms(t).rms()), std::to_string(s.ambiguous(t))});
  }
  return rows;
}

const std::vector<std::string> kPoseHeader = {"pose", "from [s]", "to [s]", "samples", "joints [deg]", "spread [deg]"};

Rows poseRows(const CaptureResult& result) {
  Rows rows;
  for (std::size_t p = 0; p < result.poses.size(); ++p) {
    const SteadyPose& pose = result.poses[p];
    std::string angles, spreads;
    for (std::size_t j = 0; j < result.rig.joints.size(); ++j) {
      const bool revolute = result.rig.joints[j].type == JointType::kRevolute;
      const double angle =
          revolute ? pose.joints[j].angle : geodesicAngle(pose.joints[j].rotation, Eigen::Quaterniond::Identity());
      angles += fmt::format("{}{:.2f}", j ? " / " : "", toDegrees(angle));
      spreads += fmt::format("{}{:.3f}", j ? " / " : "", toDegrees(pose.spread[j]));
    }
    rows.push_back({fmt::format("p{:03}", p), fmt::format("{:.3f}", pose.start), fmt::format("{:.3f}", pose.end),
                    std::to_string(pose.samples), angles, spreads});
  }
  return rows;
}

std::string answer(const CaptureResult& result, const CaptureStatistics& s) {
  std::string text = fmt::format("{} pairs: all joints in {:.1f} % of them, {} steady poses", s.frames(),
                                 percent(result.samples.size(), s.frames()), result.poses.size());
  text += result.doubts.empty() ? "; nothing speaks against the geometry."
                                : fmt::format("; the geometry is in doubt for {} reasons.", result.doubts.size());
  return text;
}

Rows figureRows(const CaptureResult& result, const CaptureStatistics& s) {
  Rows rows{
      {"standard deviation of a blob's centre [px]", fmt::format("{:.4f}", s.centroidSd())},
      {"epipolar error, mean and RMS [px]", fmt::format("{:+.4f}, {:.4f}", s.epipolar().mean(), s.epipolar().rms())},
      {"ghosts per pair", fmt::format("{:.1f}", s.ghosts().mean())},
      {"distances against the target file [%]", fmt::format("{:+.3f}", s.scaleErrorPercent())}};
  if (result.rig.scale_bar && s.scaleBar().count() > 0) {
    rows.push_back({"scale bar, measured and nominal [mm]",
                    fmt::format("{:.4f}, {:.4f}", 1e3 * s.scaleBar().mean(), 1e3 * result.rig.scale_bar->length)});
  }
  if (result.times.camera_lag != 0.0) {
    rows.push_back({"right camera behind left [ms]", fmt::format("{:.3f}", 1e3 * result.times.camera_lag)});
  }
  if (result.lag) {
    const bool clear = result.lag->correlation > Lag::kClearCorrelation;
    rows.push_back({"joints behind shafts [ms] (correlation)",
                    clear ? fmt::format("{:.1f} ({:.2f})", 1e3 * result.lag->seconds, result.lag->correlation)
                          : fmt::format("unclear ({:.2f})", result.lag->correlation)});
  }
  return rows;
}

/// Every n-th entry, so that a chart has at most about 1000 points.
std::size_t thinning(std::size_t n) { return 1 + n / 1000; }

Json jointChart(const CaptureResult& result) {
  std::vector<double> times;
  std::vector<Series> series;
  for (const CaptureJoint& joint : result.rig.joints) series.push_back({joint.name, {}});
  const std::size_t step = thinning(result.samples.size());
  for (std::size_t i = 0; i < result.samples.size(); i += step) {
    const JointSample& sample = result.samples[i];
    times.push_back(sample.time);
    for (std::size_t j = 0; j < series.size(); ++j) {
      const bool revolute = result.rig.joints[j].type == JointType::kRevolute;
      series[j].y.push_back(toDegrees(revolute
                                          ? sample.joints[j].angle
                                          : geodesicAngle(sample.joints[j].rotation, Eigen::Quaterniond::Identity())));
    }
  }
  return lineChart(times, series, "time [s]", "angle [deg]", false);
}

Json rmsChart(const CaptureResult& result) {
  std::vector<double> times;
  std::vector<Series> series;
  for (const MarkerTarget& target : result.targets.targets) series.push_back({target.name, {}});
  for (std::size_t i = 0; i < result.digests.size(); i += thinning(result.digests.size())) {
    times.push_back(result.digests[i].time);
    for (std::size_t t = 0; t < series.size(); ++t) series[t].y.push_back(result.digests[i].rms[t]);
  }
  return lineChart(times, series, "time [s]", "fit RMS [mm]", false);
}

Json histogramChart(const DistanceHistogram& histogram) {
  std::vector<std::string> labels;
  std::vector<double> counts;
  for (int b = 0; b < DistanceHistogram::kBins; ++b) {
    labels.push_back(fmt::format("{:.2f}", 1e3 * DistanceHistogram::kStep * (b - DistanceHistogram::kBins / 2 + 0.5)));
    counts.push_back(static_cast<double>(histogram.counts[static_cast<std::size_t>(b)]));
  }
  return barChart(labels, {{"measured - nominal distance [mm]", counts}}, "pairs of markers");
}

}  // namespace

Json toJson(const CaptureResult& result, const CaptureStatistics& s) {
  Json targets = Json::array();
  for (std::size_t t = 0; t < result.targets.targets.size(); ++t) {
    targets.push_back({{"name", result.targets.targets[t].name},
                       {"visible_percent", percent(s.found(t), s.frames())},
                       {"markers", s.markers(t).mean()},
                       {"rms_mm", 1e3 * s.rms(t).rms()},
                       {"ambiguous_frames", s.ambiguous(t)}});
  }
  Json doubts = Json::array();
  for (const GeometryFinding& f : result.doubts) doubts.push_back({{"name", f.name}, {"sentence", f.sentence}});
  Json poses = Json::array();
  for (std::size_t p = 0; p < result.poses.size(); ++p) {
    const SteadyPose& pose = result.poses[p];
    Json spread = Json::object();
    for (std::size_t j = 0; j < result.rig.joints.size(); ++j) {
      spread[result.rig.joints[j].name] = toDegrees(pose.spread[j]);
    }
    poses.push_back({{"pose", fmt::format("p{:03}", p)},
                     {"start_s", pose.start},
                     {"end_s", pose.end},
                     {"samples", pose.samples},
                     {"spread_deg", spread}});
  }
  const bool bar = result.rig.scale_bar && s.scaleBar().count() > 0;
  return {{"format", "simgap/capture/1"},
          {"pairs", s.frames()},
          {"pairs_with_all_joints", result.samples.size()},
          {"skipped", result.skipped},
          {"targets", targets},
          {"ghosts_per_pair", s.ghosts().mean()},
          {"rejected_blobs",
           {{"area", s.rejections().area}, {"circularity", s.rejections().circularity}, {"edge", s.rejections().edge}}},
          {"centroid_sd_px", s.centroidSd()},
          {"epipolar_px", {{"mean", s.epipolar().mean()}, {"rms", s.epipolar().rms()}}},
          {"scale_error_percent", s.scaleErrorPercent()},
          {"scale_bar_mm", bar ? Json({{"measured", 1e3 * s.scaleBar().mean()},
                                       {"sd", 1e3 * s.scaleBar().sd()},
                                       {"nominal", 1e3 * result.rig.scale_bar->length}})
                               : Json(nullptr)},
          {"camera_lag_ms", 1e3 * result.times.camera_lag},
          {"shaft_lag_ms", result.lag ? Json(1e3 * result.lag->seconds) : Json(nullptr)},
          {"shaft_correlation", result.lag ? Json(result.lag->correlation) : Json(nullptr)},
          {"geometry", {{"verdict", result.doubts.empty() ? "consistent" : "doubtful"}, {"findings", doubts}}},
          {"poses", poses},
          {"poses_outside_shaft_log", result.poses_outside_log}};
}

std::string terminalTable(const CaptureResult& result, const CaptureStatistics& s) {
  Rows targets = targetRows(result, s);
  targets.insert(targets.begin(), kTargetHeader);
  Rows poses = poseRows(result);
  poses.insert(poses.begin(), kPoseHeader);
  std::string text = answer(result, s) + "\n\n" + alignedTable(targets) + "\n" + alignedTable(figureRows(result, s)) +
                     "\n" + alignedTable(poses);
  for (const GeometryFinding& finding : result.doubts) text += "DOUBT: " + finding.sentence + "\n";
  return text;
}

Page makePage(const CaptureResult& result, const CaptureStatistics& s) {
  Page page;
  page.title = "simgap capture";
  page.answer = answer(result, s);
  page.tables.push_back({"Targets", kTargetHeader, targetRows(result, s)});
  page.tables.push_back({"Figures", {"", ""}, figureRows(result, s)});
  if (!result.doubts.empty()) {
    Rows rows;
    for (const GeometryFinding& f : result.doubts) rows.push_back({f.name, f.sentence});
    page.tables.push_back({"Why the geometry is in doubt", {"what", "found"}, rows});
  }
  page.charts.push_back({"Joints (a spherical joint: angle from the zero pose)", jointChart(result)});
  page.charts.push_back({"Fit of the targets", rmsChart(result)});
  page.charts.push_back({"Distances between markers of a target", histogramChart(s.histogram())});
  page.details.push_back({"Steady poses", kPoseHeader, poseRows(result)});
  Rows distances;
  for (const DistanceStatistics& d : s.distances()) {
    distances.push_back({fmt::format("{} {}-{}", result.targets.targets[static_cast<std::size_t>(d.target)].name,
                                     d.markers[0], d.markers[1]),
                         fmt::format("{:.3f}", 1e3 * d.nominal), fmt::format("{:.3f}", 1e3 * d.measured.mean()),
                         fmt::format("{:.4f}", 1e3 * d.measured.sd()),
                         fmt::format("{:.4f}", 1e3 * std::sqrt(d.variance.mean()))});
  }
  page.details.push_back({"Distances [mm]", {"markers", "nominal", "mean", "sd", "predicted sd"}, distances, true});
  return page;
}

}  // namespace simgap
