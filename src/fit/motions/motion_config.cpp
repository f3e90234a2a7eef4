#include <fmt/format.h>

#include "fit/poses/calibration_yaml.h"
#include "simgap/core/error.h"
#include "simgap/fit/motions/motion_calibration.h"

namespace simgap {
namespace {

void readMotionBlock(const YamlNode& node, MotionCalibrationConfig& config) {
  MotionPosterior::Options& motions = config.motions;
  motions.motion = MotionOptions::read(node);
  if (const auto rounds = node.find("rounds")) config.rounds = static_cast<int>(rounds->integer(1, 1000));
  const auto read = [&](double& value, std::string_view stem, std::string_view unit) {
    value = node.findQuantity(stem, unit, kPositive).value_or(value);
  };
  read(motions.capture_delay_sd, "capture_delay_sd", "s");
  read(motions.discrepancy.joints, "joint_discrepancy", "rad");
  read(motions.discrepancy.slides, "slide_discrepancy", "m");
  read(motions.discrepancy.shafts, "shaft_discrepancy", "rad");
  read(motions.discrepancy.currents, "current_discrepancy", "A");
  motions.noise.joints = node.findQuantity("joint_sd", "rad", kPositive);
  motions.noise.slides = node.findQuantity("slide_sd", "m", kPositive);
  motions.noise.shafts = node.findQuantity("shaft_sd", "rad", kPositive);
  motions.noise.currents = node.findQuantity("current_sd", "A", kPositive);
}

}  // namespace

MotionCalibrationConfig MotionCalibrationConfig::read(const YamlNode& root) {
  MotionCalibrationConfig config;
  root.at("format").oneOf({"simgap/calibration/1"});
  config.parameters = ParameterSpace::readChoices(root.at("parameters"));
  if (const auto strategy = root.find("strategy")) config.strategy = readStrategy(*strategy);
  if (const auto optimizer = root.find("optimizer")) config.optimizer = optimizer->oneOf({"lm", "es", "cma-es"});
  if (const auto motions = root.find("motions")) readMotionBlock(*motions, config);
  if (const auto friction = root.find("joint_friction_in_noise"))
    config.pose_noise.joint_friction = friction->boolean();
  config.pose_noise.capture_sd =
      root.findQuantity("capture_sd", "rad", kPositive).value_or(config.pose_noise.capture_sd);
  config.pose_noise.slide_sd = root.findQuantity("slide_sd", "m", kPositive).value_or(config.pose_noise.slide_sd);
  root.expectAllRead();
  return config;
}

std::string MotionCalibrationConfig::toYaml() const {
  std::string text = "format: simgap/calibration/1\nparameters:\n";
  for (const ParameterSpace::Choice& choice : parameters) text += choiceYaml(choice);
  text += strategyYaml(strategy) +
          fmt::format("optimizer: {}\ncapture_sd_rad: {}\nslide_sd_m: {}\njoint_friction_in_noise: {}\nmotions:\n",
                      optimizer, pose_noise.capture_sd, pose_noise.slide_sd, pose_noise.joint_friction) +
          motions.motion.toYaml("  ");
  const auto add = [&text](const char* key, double value) { text += fmt::format("  {}: {}\n", key, value); };
  text += fmt::format("  rounds: {}\n", rounds);
  add("capture_delay_sd_s", motions.capture_delay_sd);
  add("joint_discrepancy_rad", motions.discrepancy.joints);
  add("slide_discrepancy_m", motions.discrepancy.slides);
  add("shaft_discrepancy_rad", motions.discrepancy.shafts);
  add("current_discrepancy_A", motions.discrepancy.currents);
  if (motions.noise.joints) add("joint_sd_rad", *motions.noise.joints);
  if (motions.noise.slides) add("slide_sd_m", *motions.noise.slides);
  if (motions.noise.shafts) add("shaft_sd_rad", *motions.noise.shafts);
  if (motions.noise.currents) add("current_sd_A", *motions.noise.currents);
  return text;
}

}  // namespace simgap
