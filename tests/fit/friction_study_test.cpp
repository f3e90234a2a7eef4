// Studies over many simulated logs: coverage, bias, and the certificate of the global minimum.
#include <gtest/gtest.h>

#include <random>
#include <string_view>

#include "simgap/fit/friction_fit.h"
#include "support/friction_logs.h"

namespace simgap::test {
namespace {

using reality::DriveTruth;
using reality::simulateFrictionLog;

constexpr int kLogs = 200;

struct True {
  const char* name;
  double value;
};

struct Study {
  std::vector<int> covered;
  std::vector<double> mean, error;  ///< of the estimates' deviation from the truth, and its standard error
};

Study studyLogs(const DriveTruth& truth, std::size_t rows, const std::vector<True>& parameters) {
  Study study;
  study.covered.assign(parameters.size(), 0);
  std::vector<double> sum(parameters.size()), squares(parameters.size());
  FrictionFitOptions options;
  options.folds = 0;
  for (int log = 0; log < kLogs; ++log) {
    const FrictionData data = frictionData(simulateFrictionLog(
        truth, {.rows = rows, .sessions = 12, .seed = 1000 + rows + static_cast<std::size_t>(log)}));
    const FrictionFit fit = fitFriction(friction::find("variant-a"), data, options);
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      for (const Estimate& e : fit.uncertainty.estimates) {
        if (e.name != parameters[p].name) continue;
        study.covered[p] += e.lower95 <= parameters[p].value && parameters[p].value <= e.upper95;
        sum[p] += e.value - parameters[p].value;
        squares[p] += (e.value - parameters[p].value) * (e.value - parameters[p].value);
      }
    }
  }
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const double mean = sum[p] / kLogs;
    study.mean.push_back(mean);
    study.error.push_back(std::sqrt(squares[p] / kLogs - mean * mean) / std::sqrt(kLogs));
    std::printf("%-6s covered %.1f %%, mean error %+.2f standard errors\n", parameters[p].name,
                100.0 * study.covered[p] / kLogs, mean / study.error[p]);
  }
  return study;
}

std::vector<True> namesAndValues(const DriveTruth& truth) {
  return {{"k_a", truth.torque_per_ampere},  {"n_c1", truth.sliding_per_load}, {"n_c2", truth.sliding_offset},
          {"n_s", truth.breakaway_per_load}, {"k_v", truth.viscous},           {"v_s", truth.stribeck_velocity},
          {"delta", truth.stribeck_exponent}};
}

TEST(SlowFrictionStudy, IntervalsCoverTheTruthUnderCorrelatedNoise) {
  DriveTruth truth;
  truth.sliding_offset = 0.6;
  truth.noise = 0.5;
  truth.noise_memory = 0.8;
  const std::vector<True> parameters = namesAndValues(truth);
  const Study study = studyLogs(truth, 12000, parameters);
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    EXPECT_GE(study.covered[p], 0.90 * kLogs) << parameters[p].name;
    EXPECT_LE(study.covered[p], 0.98 * kLogs) << parameters[p].name;
  }
}

TEST(SlowFrictionStudy, MeansAreUnbiased) {
  DriveTruth truth;
  truth.sliding_offset = 0.6;
  truth.noise = 0.25;
  const std::vector<True> parameters = namesAndValues(truth);
  const Study study = studyLogs(truth, 20000, parameters);
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    // delta bends the model most: least squares finds it a sixth of its standard deviation too high here (2.1 standard
    // errors of 200 logs), its finite-sample bias; that falls with the variance.
    const double allowed = std::string_view(parameters[p].name) == "delta" ? 0.25 * std::sqrt(kLogs) : 2.0;
    EXPECT_LE(std::abs(study.mean[p]), allowed * study.error[p]) << parameters[p].name;
  }
}

TEST(SlowFrictionStudy, NoRandomStartFindsALowerCost) {
  // 50 logs, 1000 random starts each as in 003 (drawn from 1e-4 to 20), bounded least squares on the same residuals.
  constexpr int kHardLogs = 50, kStarts = 1000;
  int best_of_all = 0;
  double worst = 0.0;
  for (int log = 0; log < kHardLogs; ++log) {
    std::mt19937_64 random(static_cast<std::uint64_t>(log));
    std::uniform_real_distribution<double> uniform;
    DriveTruth truth;
    truth.sliding_offset = log % 2 == 0 ? 0.0 : 0.5 + uniform(random);
    truth.stribeck_velocity = 3.0 + 20.0 * uniform(random);
    truth.noise = 0.5;
    const FrictionData data =
        frictionData(simulateFrictionLog(truth, {.rows = 400, .sessions = 4, .seed = static_cast<std::uint64_t>(log)}));
    const char* const laws[] = {"classic", "variant-a", "variant-b"};
    const FrictionLaw& law = friction::find(laws[log % 3]);
    FrictionFitOptions options;
    options.folds = 0;
    const FrictionFit fit = fitFriction(law, data, options);
    const LeastSquaresProblem problem = makeFrictionProblem(law, data, options);
    LeastSquaresOptions local;
    local.max_iterations = 60;
    local.function_tolerance = 1e-9;
    double lowest = std::numeric_limits<double>::infinity();
    for (int s = 0; s < kStarts; ++s) {
      std::vector<double> start;
      for (std::size_t i = 0; i < problem.parameters.size(); ++i) start.push_back(1e-4 + 20.0 * uniform(random));
      lowest = std::min(lowest, minimise(problem, start, local).cost);
    }
    const double ours = fit.mse * static_cast<double>(fit.n);
    worst = std::max(worst, ours / lowest - 1.0);
    best_of_all += ours <= lowest * (1.0 + 1e-6);
  }
  std::printf("never above the best of %d starts on %d of %d logs; worst excess %.2e\n", kStarts, best_of_all, kHardLogs,
              worst);
  EXPECT_EQ(best_of_all, kHardLogs);
}

}  // namespace
}  // namespace simgap::test
