#include "simgap/report/poses/design_report.h"

#include <fmt/format.h>

#include "pose_tables.h"

namespace simgap {
namespace {

std::vector<std::string> header(const DesignResult& result) {
  std::vector<std::string> header{"predicted mean joint error of unseen poses [deg]"};
  for (const Joint& joint : result.model.joints) header.push_back(joint.name);
  return header;
}

std::vector<std::string> row(std::string name, const PredictedError& predicted) {
  std::vector<std::string> row{std::move(name)};
  for (std::size_t j = 0; j < predicted.mean.size(); ++j) {
    row.push_back(fmt::format("{} ({} to {})", degreesText(predicted.mean[j]), degreesText(predicted.lower[j]),
                              degreesText(predicted.upper[j])));
  }
  return row;
}

std::vector<std::vector<std::string>> rows(const DesignResult& result) {
  const PoseDesign& design = result.design;
  std::vector<std::vector<std::string>> rows;
  rows.push_back(row(fmt::format("the {} recorded poses", result.recorded.poses.size()), design.before));
  for (std::size_t k = 0; k < design.after.size(); ++k) {
    rows.push_back(row(fmt::format("and {}", design.poses[k].name), design.after[k]));
  }
  rows.push_back(row(fmt::format("{} random commands instead", design.poses.size()), design.after_random));
  return rows;
}

}  // namespace

Json toJson(const DesignResult& result) {
  const PoseLayout layout = result.model.poseLayout();
  Json poses = Json::array();
  for (std::size_t k = 0; k < result.design.poses.size(); ++k) {
    Json shafts = Json::object();
    for (std::size_t m = 0; m < result.model.muscles.size(); ++m) {
      shafts[result.model.muscles[m].name] = result.design.poses[k].shafts[m];
    }
    poses.push_back({{"pose", result.design.poses[k].name},
                     {"shaft_rad", shafts},
                     {"predicted_mje_deg", predictionJson(layout, result.design.after[k])}});
  }
  return {{"format", "simgap/design/1"},
          {"recorded", result.recorded.poses.size()},
          {"candidates", result.options.candidates},
          {"criterion", result.options.criterion == DesignCriterion::kInformation ? "information" : "prediction"},
          {"predicted_mje_deg",
           {{"before", predictionJson(layout, result.design.before)},
            {"after", predictionJson(layout, result.design.after.back())},
            {"after_random", predictionJson(layout, result.design.after_random)}}},
          {"poses", poses}};
}

std::string nextPosesCsv(const DesignResult& result) {
  std::vector<std::string> columns{"pose"};
  for (const Muscle& muscle : result.model.muscles) columns.push_back("shaft_" + muscle.name + "_rad");
  for (const Joint& joint : result.model.joints) {
    if (joint.type == JointType::kRevolute) {
      columns.push_back(joint.name + "_rad");
    } else {
      for (const char* c : {"_qw", "_qx", "_qy", "_qz"}) columns.push_back(joint.name + c);
    }
  }
  CsvWriter csv(columns);
  for (const Pose& pose : result.design.poses) {
    csv.add(pose.name);
    for (const double shaft : pose.shafts) csv.add(shaft);
    for (std::size_t j = 0; j < pose.joints.size(); ++j) {
      if (result.model.joints[j].type == JointType::kRevolute) {
        csv.add(pose.joints[j].angle);
      } else {
        const Eigen::Quaterniond& q = pose.joints[j].rotation;
        csv.add(q.w()).add(q.x()).add(q.y()).add(q.z());
      }
    }
    csv.endRow();
  }
  return csv.text();
}

std::string terminalTable(const DesignResult& result) {
  std::vector<std::vector<std::string>> table{header(result)};
  for (auto& line : rows(result)) table.push_back(line);
  return alignedTable(table) + "record the commands of next_poses.csv in this order; calibrate with all poses\n";
}

}  // namespace simgap
