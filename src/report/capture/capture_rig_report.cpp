#include "simgap/report/capture/capture_rig_report.h"

#include <fmt/format.h>

#include "capture_tables.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

Json vectorJson(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

// ------------------------------------------------------------------------------------------ calibrate-joints

Json jointJson(const FunctionalJoint& j) {
  Json json = {{"name", j.name},
               {"frames", j.frames},
               {fmt::format("range_{}", kindOf(j.type).error_unit), kindOf(j.type).shown(j.range)},
               {"residual_mm", 1e3 * j.residual},
               {"centre_sd_mm", 1e3 * j.centre_sd},
               {"condition", j.condition},
               {"in_parent_m", vectorJson(j.in_parent)},
               {"in_child_m", vectorJson(j.in_child)}};
  if (kindOf(j.type).has_axis) {
    json["axis_sd_deg"] = toDegrees(j.axis_sd);
    json["axis_in_parent"] = vectorJson(j.axis_in_parent);
    json["axis_in_child"] = vectorJson(j.axis_in_child);
  }
  return json;
}

// --------------------------------------------------------------------------------------------- targets check

Json likenessJson(const TargetSetReport& report, const Likeness& l) {
  return {{"from", report.targets[l.from].name},
          {"to", report.targets[l.to].name},
          {"markers", l.markers},
          {"taken_for", l.taken_for},
          {"mirrored", l.mirrored},
          {"rms_mm", numberOrNull(1e3 * l.rms)},
          {"confused", report.confused(l)}};
}

}  // namespace

Json toJson(const RigCalibration& r) {
  Json joints = Json::array(), bones = Json::array();
  for (const FunctionalJoint& joint : r.joints) joints.push_back(jointJson(joint));
  for (const BoneLength& bone : r.bones) {
    bones.push_back({{"from", bone.from}, {"to", bone.to}, {"length_mm", 1e3 * bone.length}});
  }
  return {{"format", "simgap/calibrate-joints/1"},
          {"joints", joints},
          {"bones", bones},
          {"zero_pose_from_frames", r.zero_pose}};
}

std::string terminalTable(const RigCalibration& r) {
  const Json result = toJson(r);
  return jointAnswer(result) + "\n\n" + alignedTable(jointTable(result));
}

Json toJson(const TargetSetReport& report) {
  Json targets = Json::array();
  for (const TargetReport& t : report.targets) {
    targets.push_back({{"name", t.name},
                       {"smallest_gap_mm", 1e3 * t.smallest_gap},
                       {"from_plane_mm", 1e3 * t.flatness},
                       {"symmetry", likenessJson(report, t.symmetry)},
                       {"mirror", likenessJson(report, t.mirror)},
                       {"triple", likenessJson(report, t.triple)}});
  }
  Json cross = Json::array(), triples = Json::array();
  for (const Likeness& l : report.cross) cross.push_back(likenessJson(report, l));
  for (const Likeness& l : report.cross_triple) triples.push_back(likenessJson(report, l));
  return {{"format", "simgap/targets-check/1"},
          {"noise_mm", 1e3 * report.noise},
          {"sound", report.sound()},
          {"targets", targets},
          {"cross", cross},
          {"cross_triples", triples}};
}

std::string terminalTable(const TargetSetReport& report) {
  const Json result = toJson(report);
  const Table cross = crossTable(result);
  return targetAnswer(result) + "\n\n" + alignedTable(targetTable(result)) +
         (cross.rows.empty() ? "" : "\n" + alignedTable(cross)) + "lengths in mm: what noise must bridge\n";
}

}  // namespace simgap
