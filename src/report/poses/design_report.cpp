#include "simgap/report/poses/design_report.h"

#include <fmt/format.h>

#include "pose_tables.h"
#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/arm_geometry.h"

namespace simgap {

Json toJson(const DesignResult& result) {
  const PoseLayout layout = result.model.poseLayout();
  Json poses = Json::array();
  for (std::size_t k = 0; k < result.design.poses.size(); ++k) {
    Json shafts = Json::object();
    for (std::size_t m = 0; m < result.model.muscles.size(); ++m) {
      shafts[result.model.muscles[m].name] = result.design.poses[k].shafts[m];
    }
    Json pose = {{"pose", result.design.poses[k].name}, {"shaft_rad", shafts}};
    for (std::size_t l = 0; l < layout.lines.size(); ++l) {
      pose[layout.lines[l].stem + "_" + layout.lines[l].unit] =
          result.design.poses[k].shafts[result.model.muscles.size() + l];
    }
    for (const std::string& unit : errorUnits(layout)) {
      pose["predicted_mje_" + unit] = predictionJson(layout, result.design.after[k], unit);
    }
    poses.push_back(std::move(pose));
  }
  Json json = {{"format", "simgap/design/1"},
               {"recorded", result.recorded.poses.size()},
               {"candidates", result.options.candidates},
               {"criterion", result.options.criterion == DesignCriterion::kInformation ? "information" : "prediction"}};
  for (const std::string& unit : errorUnits(layout)) {
    json["predicted_mje_" + unit] = {{"before", predictionJson(layout, result.design.before, unit)},
                                     {"after", predictionJson(layout, result.design.after.back(), unit)},
                                     {"after_random", predictionJson(layout, result.design.after_random, unit)}};
  }
  json["poses"] = poses;
  return json;
}

std::string nextPosesCsv(const DesignResult& result) {
  std::vector<std::string> columns{"pose"};
  for (const Muscle& muscle : result.model.muscles) columns.push_back("shaft_" + muscle.name + "_rad");
  for (const CommandChannel& line : result.model.poseLayout().lines) columns.push_back(line.stem + "_" + line.unit);
  for (const Joint& joint : result.model.joints) {
    for (std::string& column : positionColumns(joint.type, joint.name)) columns.push_back(std::move(column));
  }
  CsvWriter csv(columns);
  for (const Pose& pose : result.design.poses) {
    csv.add(pose.name);
    for (const double shaft : pose.shafts) csv.add(shaft);
    for (std::size_t j = 0; j < pose.joints.size(); ++j) {
      for (const double cell : kindOf(result.model.joints[j].type).cells(pose.joints[j])) csv.add(cell);
    }
    csv.endRow();
  }
  return csv.text();
}

std::string terminalTable(const DesignResult& result) {
  const Table errors = expectedErrors(toJson(result));
  return errors.caption + "\n" + alignedTable(errors) +
         "record the commands of next_poses.csv in this order; calibrate with all poses\n";
}

void writeDesignReport(const DesignResult& result, const RunDirectory& directory) {
  const PoseSet next{"next_poses.csv", result.design.poses};
  const ReplayedSet replay{"next", "expected", result.model, next, result.expected.outcomes};
  writeArmGeometry({&replay, 1}, directory);
  directory.write("next_poses.csv", nextPosesCsv(result));
  directory.write("model.yaml", writeArm(result.model));
}

}  // namespace simgap
