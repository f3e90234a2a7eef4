#include "simgap/report/capture/capture_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture_tables.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

double percent(std::size_t part, std::size_t all) {
  return all > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(all) : 0.0;
}

/// Rates, what was lost, and how late an angle is behind its image.
Json liveJson(const LiveFigures& live) {
  const auto pairOf = [](const std::array<std::size_t, 2>& counts) { return Json{counts[0], counts[1]}; };
  const auto latency = [&](double part) {
    return live.latency.count() > 0 ? Json(1e3 * live.latency.quantile(part)) : Json(nullptr);
  };
  return {{"seconds", live.seconds},
          {"frames", pairOf(live.counts.frames)},
          {"dropped", pairOf(live.counts.dropped)},
          {"unpaired", pairOf(live.counts.unpaired)},
          {"pairs_per_s", static_cast<double>(live.pairs) / live.seconds},
          {"poses_per_s", static_cast<double>(live.poses) / live.seconds},
          {"latency_ms", {{"median", latency(0.5)}, {"p95", latency(0.95)}, {"largest", latency(1.0)}}},
          {"started_unix_s", live.started_unix}};
}

Json restJson(std::size_t number, const SteadyPose& pose, const std::vector<CaptureJoint>& joints) {
  Json spread = Json::object(), slide_spread = Json::object();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    (kindOf(joints[j].type).slides ? slide_spread : spread)[joints[j].name] =
        kindOf(joints[j].type).shown(pose.spread[j]);
  }
  Json rest = {{"pose", fmt::format("p{:03}", number)},
               {"start_s", pose.start},
               {"end_s", pose.end},
               {"samples", pose.samples},
               {"spread_deg", spread}};
  if (!slide_spread.empty()) rest["spread_mm"] = slide_spread;
  return rest;
}

}  // namespace

LongList posesOf(const CaptureResult& result) {
  return {"poses", result.poses.size(),
          [&result](std::size_t p) { return restJson(p, result.poses.at(p), result.rig.joints); }};
}

Json toJson(const CaptureResult& result, const CaptureStatistics& s) {
  Json targets = Json::array();
  for (std::size_t t = 0; t < result.targets.targets.size(); ++t) {
    Json markers = Json::array();
    for (const Eigen::Vector3d& m : result.targets.targets[t].markers) markers.push_back({m.x(), m.y(), m.z()});
    targets.push_back({{"name", result.targets.targets[t].name},
                       {"markers_m", markers},
                       {"visible_percent", percent(s.found(t), s.frames())},
                       {"markers", s.markers(t).mean()},
                       {"rms_mm", 1e3 * s.rms(t).rms()},
                       {"ambiguous_frames", s.ambiguous(t)}});
  }
  Json joint_types = Json::object();
  for (const CaptureJoint& joint : result.rig.joints) {
    joint_types[joint.name] = kindOf(joint.type).name;
  }
  Json doubts = Json::array();
  for (const GeometryFinding& f : result.doubts) doubts.push_back({{"name", f.name}, {"sentence", f.sentence}});
  Json live = nullptr;
  if (result.live) live = liveJson(*result.live);
  const bool bar = result.rig.scale_bar && s.scaleBar().count() > 0;
  return {{"format", "simgap/capture/1"},
          {"pairs", s.frames()},
          {"pairs_with_all_joints", result.samples},
          {"skipped", result.skipped},
          {"marker_radius_m", result.targets.marker_radius},
          {"targets", targets},
          {"joint_types", joint_types},
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
          {"poses", Json::array()},
          {"live", live},
          {"poses_outside_shaft_log", result.poses_outside_log}};
}

std::string terminalTable(const CaptureResult& result, const CaptureStatistics& s) {
  Json json = toJson(result, s);
  const LongList poses = posesOf(result);
  CsvWriter csv = posesCsv(result.rig.joints, result.muscles);
  for (std::size_t p = 0; p < std::min(poses.size, kMostPosesShown); ++p) {
    json["poses"].push_back(poses.element(p));
    addPose(csv, p, result.poses.at(p), result.rig.joints);
  }
  std::string text = captureAnswer(json, poses.size) + "\n\n" + alignedTable(sightingTable(json)) + "\n" +
                     alignedTable(captureFigures(json).rows) + "\n" +
                     alignedTable(poseTable(json, CsvTable::parse(csv.text(), "poses.csv")));
  if (poses.size > kMostPosesShown) text += morePoses(poses.size) + "\n";
  for (const GeometryFinding& finding : result.doubts) text += "DOUBT: " + finding.sentence + "\n";
  return text;
}

}  // namespace simgap
