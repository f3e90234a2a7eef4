#include "support/analytic_evaluator.h"

namespace simgap::test {
namespace {

PoseOutcome outcomeOf(const ArmModel& model, std::size_t pose) {
  PoseOutcome outcome;
  outcome.status = PoseStatus::kSteady;
  outcome.joints.resize(2);
  outcome.joints[0].rotation = Eigen::AngleAxisd(model.muscles[1].kite_line_length, Eigen::Vector3d::UnitX());
  outcome.joints[1].angle = model.muscles[0].kite_line_length + static_cast<double>(pose);
  outcome.shafts = {0.0, 0.0};
  outcome.cord_expansion = {0.0, 0.0};
  return outcome;
}

}  // namespace

ArmModel analyticArm() {
  ArmModel model;
  model.name = "analytic";
  model.bodies.resize(3);
  model.bodies[0] = {"torso", true, {}, {}};
  for (int i = 1; i < 3; ++i) {
    Part part;
    part.name = "bone";
    part.radius = 0.01;
    part.length = 0.2;
    part.mass = 1.0;
    model.bodies[i] = {i == 1 ? "upper" : "fore", false, {part}, {}};
    Joint joint;
    joint.name = i == 1 ? "shoulder" : "elbow";
    joint.type = i == 1 ? JointType::kSpherical : JointType::kRevolute;
    joint.parent = i - 1;
    joint.child = i;
    model.joints.push_back(joint);
  }
  model.motor_defaults = {0.8, 3e-4, 0.011, 0.011, 2e-6, 1e-6, 0.002, 12.0};
  model.gearbox_defaults = {72.0, 0.72, 1e-5, 0.002, 0.03};
  for (const auto& [name, line] : {std::pair{"biceps", 0.1}, std::pair{"triceps", 0.2}}) {
    Muscle muscle;
    muscle.name = name;
    muscle.attachments = {Attachment{0, {0.1, 0, 0}}, Attachment{2, {0, 0.1, 0}}};
    muscle.kite_line_length = line;
    muscle.shock_cord = {0.08, 900.0, 15.0};
    muscle.spindle_radius = 0.006;
    muscle.motor = model.motor_defaults;
    muscle.gearbox = model.gearbox_defaults;
    model.muscles.push_back(muscle);
  }
  return model;
}

std::vector<Pose> analyticPoses() {
  std::vector<Pose> poses;
  for (int i = 0; i < 2; ++i) {
    Pose pose{i == 0 ? "low" : "high", {0.0, 0.0}, std::vector<JointPosition>(2), 1, {0.0, 0.0}};
    pose.joints[0].rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
    pose.joints[1].angle = 0.3 + i;
    poses.push_back(pose);
  }
  return poses;
}

CalibrationConfig analyticConfig() {
  CalibrationConfig config;
  config.parameters = {{"muscles.*.kite_line_length_m", 0.05, {}, {}, {}, {}}};
  config.optimizer = "es";
  config.strategy.mu = 3;
  config.strategy.lambda = 12;
  config.strategy.generations = 8;
  config.strategy.seed = 7;
  return config;
}

std::vector<PoseOutcome> AnalyticEvaluator::evaluate(std::span<const ArmModel> models, std::span<const Pose> poses,
                                                     AfterInvalid after_invalid) {
  std::vector<PoseOutcome> outcomes;
  for (const ArmModel& model : models) {
    bool skip = false;
    for (std::size_t p = 0; p < poses.size(); ++p) {
      PoseOutcome outcome = outcomeOf(model, p);
      if (spoil_) spoil_(model, p, outcome);
      outcomes.push_back(skip ? PoseOutcome{} : outcome);
      skip = skip || (outcome.status != PoseStatus::kSteady && after_invalid == AfterInvalid::kSkipRest);
    }
  }
  return outcomes;
}

}  // namespace simgap::test
