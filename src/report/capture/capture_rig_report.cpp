#include "simgap/report/capture/capture_rig_report.h"
#include "simgap/report/text_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>


namespace simgap {
namespace {

using Rows = std::vector<std::vector<std::string>>;

Json vectorJson(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

// ------------------------------------------------------------------------------------------ calibrate-joints

std::string answer(const ArmJointCalibration& r) {
  return fmt::format(
      "Shoulder centre within {:.2f} mm, elbow axis within {:.2f} deg, upper arm {:.1f} mm; the zero pose "
      "is {}.",
      1e3 * r.shoulder.centre_sd, toDegrees(r.elbow.axis_sd), 1e3 * r.upper_arm,
      r.zero_pose ? "that of the frames named" : "that of the target file");
}

const std::vector<std::string> kJointHeader = {"joint",          "frames",        "range [deg]", "residual [mm]",
                                               "centre sd [mm]", "axis sd [deg]", "condition"};

std::vector<std::string> jointRow(const FunctionalJoint& j) {
  return {j.name,
          std::to_string(j.frames),
          fmt::format("{:.1f}", toDegrees(j.range)),
          fmt::format("{:.3f}", 1e3 * j.residual),
          fmt::format("{:.3f}", 1e3 * j.centre_sd),
          j.type == JointType::kRevolute ? fmt::format("{:.3f}", toDegrees(j.axis_sd)) : "-",
          fmt::format("{:.3f}", j.condition)};
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

const std::vector<std::string> kTargetSetHeader = {"target",      "smallest gap", "from its plane",
                                                "other order", "mirror image", "3 markers for 3 others"};

std::string millimetres(const TargetSetReport& report, const Likeness& likeness) {
  return fmt::format("{:.2f}{}", 1e3 * likeness.rms, report.confused(likeness) ? " !" : "");
}

Rows targetRows(const TargetSetReport& report) {
  Rows rows;
  for (const TargetReport& t : report.targets) {
    rows.push_back({t.name, fmt::format("{:.2f}", 1e3 * t.smallest_gap), fmt::format("{:.2f}", 1e3 * t.flatness),
                    millimetres(report, t.symmetry), millimetres(report, t.mirror), millimetres(report, t.triple)});
  }
  return rows;
}

const std::vector<std::string> kCrossHeader = {"taken for one another", "whole", "3 markers", "these 3"};

Rows crossRows(const TargetSetReport& report) {
  Rows rows;
  for (std::size_t i = 0; i < report.cross.size(); ++i) {
    const Likeness& triple = report.cross_triple[i];
    rows.push_back({report.targets[static_cast<std::size_t>(triple.from)].name + " / " +
                        report.targets[static_cast<std::size_t>(triple.to)].name,
                    millimetres(report, report.cross[i]), millimetres(report, triple),
                    fmt::format("{} / {}", fmt::join(triple.markers, " "), fmt::join(triple.taken_for, " "))});
  }
  return rows;
}

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
  return answer(r) + "\n\n" + alignedTable({kJointHeader, jointRow(r.shoulder), jointRow(r.elbow)});
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
  Rows targets = targetRows(report);
  targets.insert(targets.begin(), kTargetSetHeader);
  Rows cross = crossRows(report);
  cross.insert(cross.begin(), kCrossHeader);
  return answer(report) + "\n\n" + alignedTable(targets) + (cross.size() > 1 ? "\n" + alignedTable(cross) : "") +
         "lengths in mm: what noise must bridge\n";
}

}  // namespace simgap
