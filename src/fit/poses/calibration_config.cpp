#include <fmt/format.h>

#include "calibration_yaml.h"
#include "simgap/core/error.h"
#include "simgap/fit/poses/calibration.h"

namespace simgap {
EvolutionStrategyOptions readStrategy(const YamlNode& node) {
  constexpr long kMany = 1'000'000;
  EvolutionStrategyOptions options;
  if (const auto mu = node.find("mu")) options.mu = static_cast<int>(mu->integer(1, kMany));
  if (const auto lambda = node.find("lambda")) options.lambda = static_cast<int>(lambda->integer(1, kMany));
  if (const auto generations = node.find("generations")) {
    options.generations = static_cast<int>(generations->integer(0, kMany));
  }
  if (const auto tau = node.find("tau")) options.tau = tau->number(kNonNegative);
  if (const auto tau_prime = node.find("tau_prime")) options.tau_prime = tau_prime->number(kNonNegative);
  if (const auto target = node.find("target_fitness")) options.target_fitness = target->number();
  if (const auto seed = node.find("seed")) options.seed = seed->seed();
  try {
    options.validate();
  } catch (const ConfigError& error) {
    node.fail(error.what());
  }
  return options;
}

std::string strategyYaml(const EvolutionStrategyOptions& options) {
  std::string text = fmt::format("strategy:\n  mu: {}\n  lambda: {}\n  generations: {}\n  seed: {}\n", options.mu,
                                 options.lambda, options.generations, options.seed);
  if (options.tau) text += fmt::format("  tau: {}\n", *options.tau);
  if (options.tau_prime) text += fmt::format("  tau_prime: {}\n", *options.tau_prime);
  if (std::isfinite(options.target_fitness)) text += fmt::format("  target_fitness: {}\n", options.target_fitness);
  return text;
}

std::string choiceYaml(const ParameterSpace::Choice& choice) {
  std::string text = fmt::format("  - {{pattern: {}, step: {}", yamlText(choice.pattern), choice.step);
  const auto append = [&text](const char* key, const std::optional<double>& value) {
    if (value) text += fmt::format(", {}: {}", key, *value);
  };
  append("lower", choice.lower);
  append("upper", choice.upper);
  append("prior_sd", choice.prior_sd);
  append("prior_sd_percent", choice.prior_sd_percent);
  if (choice.together) text += ", together: true";
  if (!choice.only.empty()) text += ", only: " + yamlText(choice.only);
  return text + "}\n";
}

CalibrationConfig CalibrationConfig::read(const YamlNode& root) {
  CalibrationConfig config;
  root.at("format").oneOf({"simgap/calibration/1"});
  config.parameters = ParameterSpace::readChoices(root.at("parameters"));
  if (const auto strategy = root.find("strategy")) config.strategy = readStrategy(*strategy);
  if (const auto protocol = root.find("protocol")) config.protocol = PoseProtocol::read(*protocol);
  if (const auto evaluator = root.find("evaluator")) config.evaluator = evaluator->oneOf({"bullet", "equilibrium"});
  if (const auto optimizer = root.find("optimizer"))
    config.optimizer = optimizer->oneOf({"es", "cma-es", "lm", "hybrid"});
  if (const auto objective = root.find("objective")) {
    config.objective =
        objective->oneOf({"geodesic", "paper"}) == "paper" ? PoseObjective::kPaper : PoseObjective::kGeodesic;
  }
  if (const auto verify = root.find("verify")) config.verify = verify->oneOf({"bullet", "none"});
  if (const auto starts = root.find("starts")) config.starts = static_cast<int>(starts->integer(1, 10000));
  if (const auto only_poses = root.find("only_poses")) config.only_poses = only_poses->text();
  if (const auto friction = root.find("joint_friction_in_noise")) config.noise.joint_friction = friction->boolean();
  config.noise.capture_sd = root.findQuantity("capture_sd", "rad", kPositive).value_or(config.noise.capture_sd);
  config.noise.slide_sd = root.findQuantity("slide_sd", "m", kPositive).value_or(config.noise.slide_sd);
  root.expectAllRead();
  return config;
}

std::string CalibrationConfig::toYaml() const {
  std::string text = "format: simgap/calibration/1\nparameters:\n";
  for (const ParameterSpace::Choice& choice : parameters) text += choiceYaml(choice);
  return text + strategyYaml(strategy) + "protocol:\n" + protocol.toYaml("  ") +
         fmt::format("evaluator: {}\noptimizer: {}\nobjective: {}\nverify: {}\nstarts: {}\nonly_poses: {}\n", evaluator,
                     optimizer, toString(objective), verify, starts, yamlText(only_poses)) +
         fmt::format("capture_sd_rad: {}\nslide_sd_m: {}\njoint_friction_in_noise: {}\n", noise.capture_sd,
                     noise.slide_sd, noise.joint_friction);
}

}  // namespace simgap
