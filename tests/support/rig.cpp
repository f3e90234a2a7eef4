#include "support/rig.h"

#include "simgap/core/joint_kind.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "support/files.h"
#include "support/statics.h"

namespace simgap::test {

Pose poseOf(const ArmModel& model, const reality::RecordedPose& recorded, const std::string& name) {
  Pose pose;
  pose.name = name;
  pose.shafts = recorded.shafts;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    pose.joints.push_back({Eigen::Quaterniond(recorded.joints[j].rotation), recorded.joints[j].angle});
  }
  pose.spread.assign(model.joints.size(), 0.0);
  return pose;
}

RecordedRig recordRig(std::uint64_t seed, const reality::RigOptions& options) {
  const reality::Rig rig = reality::makeRig(seed, options);
  RecordedRig recorded{modelOf(rig.nominal, true), {}, {}};
  for (const auto& repeats : rig.calibration) {
    recorded.calibration.push_back(
        poseOf(recorded.model, repeats.front(), "p" + std::to_string(recorded.calibration.size())));
  }
  for (const reality::RecordedPose& pose : rig.validation) {
    recorded.validation.push_back(poseOf(recorded.model, pose, "v" + std::to_string(recorded.validation.size())));
  }
  return recorded;
}

ParameterSpace paperParameters(const ArmModel& model) {
  const CalibrationConfig config = CalibrationConfig::read(YamlNode::load(sourceFile("configs/calibrate_arm.yaml")));
  return ParameterSpace(model, config.parameters);
}

std::vector<double> meanJointErrors(const ArmModel& model, std::span<const Pose> poses) {
  EquilibriumArm arm(model);
  std::vector<double> mje(model.joints.size(), 0.0);
  for (const Pose& pose : poses) {
    arm.solve(pose.shafts);
    for (std::size_t j = 0; j < mje.size(); ++j) {
      mje[j] += toDegrees(jointError(model.joints[j].type, pose.joints[j], arm.joints()[j])) /
                static_cast<double>(poses.size());
    }
  }
  return mje;
}

}  // namespace simgap::test
