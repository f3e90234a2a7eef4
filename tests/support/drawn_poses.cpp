#include "support/drawn_poses.h"

#include "simgap/core/csv.h"
#include "simgap/model/arm/arm_yaml.h"
#include "support/files.h"

namespace simgap::test {

const CalibrationConfig& paperConfig() {
  static const CalibrationConfig config =
      CalibrationConfig::read(YamlNode::load(sourceFile("configs/calibrate_arm.yaml")));
  return config;
}

ArmModel modelOf(const reality::PoseDraw& draw) {
  return readArm(YamlNode::parse(reality::toYaml(draw.nominal), "arm.yaml"));
}

PoseSet posesOf(const reality::PoseDraw& draw, const std::vector<reality::TimedPose>& poses) {
  return readPoseSet(CsvTable::parse(reality::posesCsv(draw.nominal, poses), "poses.csv"), modelOf(draw).poseLayout());
}

PoseDiagnosis diagnose(const reality::PoseDraw& draw, const PoseDiagnosisOptions& options) {
  return diagnosePoses(modelOf(draw), posesOf(draw, draw.poses), paperConfig().parameters, paperConfig().noise, options,
                       [](const std::string&, double) {});
}

std::string labelOf(const std::string& effect, const std::string& target) {
  return target.empty() ? effect : effect + ":" + target;
}

}  // namespace simgap::test
