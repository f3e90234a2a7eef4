#include "simgap/report/capture/capture_rig_report.h"

#include <fmt/format.h>

#include "capture_tables.h"

namespace simgap {
namespace {

Json vectorJson(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

// ------------------------------------------------------------------------------------------ calibrate-joints

std::string answer(const ArmJointCalibration& r) {
  return fmt::format(
      "Shoulder centre within {:.2f} mm, elbow axis within {:.2f} deg, upper arm {:.1f} mm; the zero pose "
      "is {}.",
      1e3 * r.shoulder.centre_sd, toDegrees(r.elbow.axis_sd), 1e3 * r.upper_arm,
      r.zero_pose ? "that of the frames named" : "that of the target file");
}

Json jointJson(const FunctionalJoint& j) {
  Json json = {{"name", j.name},
               {"frames", j.frames},
               {"range_deg", toDegrees(j.range)},
               {"residual_mm", 1e3 * j.residual},
               {"centre_sd_mm", 1e3 * j.centre_sd},
               {"condition", j.condition},
               {"in_parent_m", vectorJson(j.in_parent)},
               {"in_child_m", vectorJson(j.in_child)}};
  if (j.type == JointType::kRevolute) {
    json["axis_sd_deg"] = toDegrees(j.axis_sd);
    json["axis_in_parent"] = vectorJson(j.axis_in_parent);
    json["axis_in_child"] = vectorJson(j.axis_in_child);
  }
  return json;
}

// --------------------------------------------------------------------------------------------- targets check

std::string answer(const TargetSetReport& report) {
  return fmt::format("{} at a noise of {:.2f} mm per marker (a likeness below {:.2f} mm is marked '!').",
                     report.sound() ? "Whole targets cannot be confused" : "Whole targets CAN be confused",
                     1e3 * report.noise, 1e3 * TargetSetReport::kMargin * report.noise);
}

Json likenessJson(const TargetSetReport& report, const Likeness& l) {
  return {{"from", report.targets[static_cast<std::size_t>(l.from)].name},
          {"to", report.targets[static_cast<std::size_t>(l.to)].name},
          {"markers", l.markers},
          {"taken_for", l.taken_for},
          {"mirrored", l.mirrored},
          {"rms_mm", numberOrNull(1e3 * l.rms)},
          {"confused", report.confused(l)}};
}

}  // namespace

Json toJson(const ArmJointCalibration& r) {
  return {{"format", "simgap/calibrate-joints/1"},
          {"joints", Json::array({jointJson(r.shoulder), jointJson(r.elbow)})},
          {"upper_arm_mm", 1e3 * r.upper_arm},
          {"zero_pose_from_frames", r.zero_pose}};
}

std::string terminalTable(const ArmJointCalibration& r) {
  return answer(r) + "\n\n" + alignedTable(jointTable(toJson(r)));
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
  return answer(report) + "\n\n" + alignedTable(targetTable(result)) +
         (cross.rows.empty() ? "" : "\n" + alignedTable(cross)) + "lengths in mm: what noise must bridge\n";
}

}  // namespace simgap
