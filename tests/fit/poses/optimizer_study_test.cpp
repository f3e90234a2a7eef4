// Is the evolution strategy of 001 superior to other techniques? The table of docs/studies/optimizers.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>

#include "simgap/fit/poses/calibration.h"
#include "simgap/fit/poses/posterior_search.h"
#include "simgap/optimize/cma_es.h"
#include "support/files.h"
#include "support/rig.h"

namespace simgap {
namespace {

constexpr int kArms = 20;

struct Row {
  std::vector<double> calibration[2], validation[2], evaluations, seconds;
};

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

void note(Row& row, const test::RecordedRig& rig, const ArmModel& model, double evaluations, double seconds) {
  const auto calibration = test::meanJointErrors(model, rig.calibration);
  const auto validation = test::meanJointErrors(model, rig.validation);
  for (std::size_t j = 0; j < 2; ++j) {
    row.calibration[j].push_back(calibration[j]);
    row.validation[j].push_back(validation[j]);
  }
  row.evaluations.push_back(evaluations);
  row.seconds.push_back(seconds);
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// As the command runs it: es and cma-es minimise the sum of squared errors, lm and hybrid maximise the posterior.
void runCommand(const char* optimizer, const test::RecordedRig& rig, Row& row) {
  CalibrationConfig config = CalibrationConfig::read(YamlNode::load(test::sourceFile("configs/calibrate_arm.yaml")));
  config.evaluator = "equilibrium";
  config.optimizer = optimizer;
  const auto evaluator = makeEquilibriumEvaluator(1);
  Calibration calibration(rig.model, rig.calibration, config, *evaluator, 1);
  const auto start = std::chrono::steady_clock::now();
  calibration.run([](const CalibrationState&) {});
  note(row, rig, calibration.bestModel(), static_cast<double>(calibration.state().evaluations), secondsSince(start));
}

// The same searches with the objective of lm: what the priors do and what the descent does.
void runOnPosterior(const char* optimizer, const test::RecordedRig& rig, Row& row) {
  const ParameterSpace space = test::paperParameters(rig.model);
  PosePosterior posterior(rig.model, rig.calibration, space, {});
  const auto start = std::chrono::steady_clock::now();
  const EvolutionStrategyOptions paper;
  constexpr double kNoEquilibrium = 1e9;
  const auto objective = [&](const std::vector<double>& z) {
    const double value = posterior.objective(Eigen::Map<const Eigen::VectorXd>(z.data(), std::ssize(z)));
    return std::isfinite(value) ? value : kNoEquilibrium;
  };
  std::vector<double> best;
  if (std::string(optimizer) == "es") {
    std::vector<ObjectParameter> parameters;
    for (Eigen::Index i = 0; i < posterior.parameters().size(); ++i) {
      parameters.push_back({0.0, kHybridStep, posterior.parameters().lower(i), posterior.parameters().upper(i)});
    }
    EvolutionStrategy strategy(parameters, paper);
    while (!strategy.stopped()) {
      std::vector<double> fitness;
      for (const Individual& individual : strategy.ask()) fitness.push_back(objective(individual.y));
      strategy.tell(fitness);
    }
    best = strategy.state().best.y;
  } else {
    const CmaEsOptions options{paper.lambda, paper.generations, kHybridStep, paper.seed};
    minimiseByCmaEs(objective, space.size(), options, [&](const CmaEsGeneration& generation) {
      best = generation.best;
      return false;
    });
  }
  const double evaluations = static_cast<double>(paper.lambda) * paper.generations * 15.0;
  note(row, rig, posterior.modelAt(Eigen::Map<const Eigen::VectorXd>(best.data(), std::ssize(best))), evaluations,
       secondsSince(start));
}

TEST(SlowOptimizerStudy, TwentyArms) {
  std::map<std::string, Row> rows;
  for (int seed = 0; seed < kArms; ++seed) {
    const test::RecordedRig rig = test::recordRig(static_cast<std::uint64_t>(seed));
    note(rows["0 hand measurements"], rig, rig.model, 0, 0);
    runCommand("es", rig, rows["1 es"]);
    runCommand("cma-es", rig, rows["2 cma-es"]);
    runOnPosterior("es", rig, rows["3 es, posterior"]);
    runOnPosterior("cma-es", rig, rows["4 cma-es, posterior"]);
    runCommand("lm", rig, rows["5 lm"]);
    runCommand("hybrid", rig, rows["6 hybrid"]);
  }
  std::cout << "median (quartiles) of " << kArms << " arms; errors [deg] shoulder / elbow; 1 thread\n";
  for (const auto& [name, row] : rows) {
    const auto both = [&](const std::vector<double>(&errors)[2]) {
      char text[100];
      std::snprintf(text, sizeof text, "%.2f (%.2f-%.2f) / %.2f (%.2f-%.2f)", quantile(errors[0], 0.5),
                    quantile(errors[0], 0.25), quantile(errors[0], 0.75), quantile(errors[1], 0.5),
                    quantile(errors[1], 0.25), quantile(errors[1], 0.75));
      return std::string(text);
    };
    std::cout << "| " << name.substr(2) << " | " << both(row.calibration) << " | " << both(row.validation) << " | "
              << quantile(row.evaluations, 0.5) << " | " << quantile(row.seconds, 0.5) << " s |\n";
  }
  EXPECT_LT(quantile(rows["5 lm"].validation[0], 0.5), quantile(rows["1 es"].validation[0], 0.5));
}

}  // namespace
}  // namespace simgap
