#include "simgap/optimize/evolution_strategy.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <set>
#include <string>

#include "objectives.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr int kSize = 10;

bool sameBits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

bool sameBits(const Individual& a, const Individual& b) {
  const auto same = [](const std::vector<double>& u, const std::vector<double>& v) {
    return std::equal(u.begin(), u.end(), v.begin(), v.end(), [](double p, double q) { return sameBits(p, q); });
  };
  return same(a.y, b.y) && same(a.s, b.s) && sameBits(a.fitness, b.fitness);
}

bool sameBits(const std::vector<Individual>& a, const std::vector<Individual>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Individual& p, const Individual& q) { return sameBits(p, q); });
}

bool sameBits(const EvolutionStrategyState& a, const EvolutionStrategyState& b) {
  return a.generation == b.generation && sameBits(a.parents, b.parents) && sameBits(a.best, b.best) &&
         a.best_generation == b.best_generation && a.stop == b.stop;
}

/// Fitness of a whole generation: `value`, but for the individuals listed.
std::vector<double> fitnessBut(double value, const std::vector<std::pair<std::size_t, double>>& others) {
  std::vector<double> fitness(36, value);
  for (const auto& [index, other] : others) fitness[index] = other;
  return fitness;
}

// Under random fitness the steps of a lineage are a random walk: per generation log s_j gains
// tau' N(0,1) + tau N_j(0,1), of mean 0. Its mean over the n steps has the variance tau'^2 + tau^2 / n, for the shared
// part does not average out; a single step has tau'^2 + tau^2. Selection that prefers large or small steps by itself,
// or numbers that are not independent, would show here.
TEST(EvolutionStrategyMutation, HasNoDriftUnderNeutralSelection) {
  constexpr int kRuns = 1000, kGenerations = 100;
  EvolutionStrategyOptions options = optionsOf(kGenerations);
  options.mu = 2;
  options.lambda = 6;
  const CounterRandom fitness_random(4711);
  double sum = 0.0, sum_squares = 0.0, single_squares = 0.0;
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed) {
    options.seed = seed;
    EvolutionStrategy strategy(box(kSize, 0.0, 1.0), options);
    for (std::uint32_t g = 0; g < kGenerations; ++g) {
      std::vector<double> fitness;
      for (std::uint32_t k = 0; k < 6; ++k) fitness.push_back(fitness_random.uniform({g, k, seed, 0}));
      strategy.tell(fitness);
    }
    const std::vector<double>& s = strategy.state().parents.front().s;
    double mean_log = 0.0;
    for (const double value : s) mean_log += std::log(value) / kSize;
    sum += mean_log;
    sum_squares += mean_log * mean_log;
    single_squares += std::log(s[0]) * std::log(s[0]);
  }
  const double tau_prime2 = 1.0 / (2.0 * kSize), tau2 = 1.0 / (2.0 * std::sqrt(double{kSize}));
  const double variance = kGenerations * (tau_prime2 + tau2 / kSize);
  const double standard_error = std::sqrt(variance / kRuns);
  const double drift = sum / kRuns;
  const double measured = sum_squares / kRuns, measured_single = single_squares / kRuns;
  const double single = kGenerations * (tau_prime2 + tau2);
  const std::string report = fmt::format(
      "mean log step {:+.4f} after {} generations, {:.2f} standard errors; variance {:.3f} (theory {:.3f}), of one "
      "step "
      "{:.3f} (theory {:.3f})",
      drift, kGenerations, drift / standard_error, measured, variance, measured_single, single);
  RecordProperty("neutral_drift", report);
  fmt::print("{}\n", report);
  EXPECT_NEAR(drift, 0.0, 3.0 * standard_error);
  // The mean of kRuns squares of normal numbers has the relative standard error sqrt(2 / kRuns).
  EXPECT_NEAR(measured / variance, 1.0, 4.0 * std::sqrt(2.0 / kRuns));
  EXPECT_NEAR(measured_single / single, 1.0, 4.0 * std::sqrt(2.0 / kRuns));
}

TEST(EvolutionStrategyMutation, StaysInsideTheRanges) {
  const std::vector<ObjectParameter> parameters = {{0.5, 1.0, 0.0, 1.0}, {-2.0, 5.0, -2.0, kInf}, {3.0, 1.0, 3.0, 3.0}};
  EvolutionStrategy strategy(parameters, optionsOf(50));
  std::set<double> reached;
  while (!strategy.stopped()) {
    for (const Individual& child : strategy.ask()) {
      for (std::size_t j = 0; j < parameters.size(); ++j) {
        ASSERT_GE(child.y[j], parameters[j].lower);
        ASSERT_LE(child.y[j], parameters[j].upper);
      }
      reached.insert(child.y[0]);
    }
    step(strategy, [](const std::vector<double>& y) { return y[1]; });
  }
  EXPECT_TRUE(reached.contains(0.0) && reached.contains(1.0)) << "a bound is set exactly";
  EXPECT_EQ(strategy.state().best.y[1], -2.0);
}

TEST(EvolutionStrategyMutation, StepsNeverVanishNorOverflow) {
  EvolutionStrategyOptions options = optionsOf(400);
  options.tau = 30.0;
  EvolutionStrategy strategy({{0.0, 1.0, -kInf, kInf}, {0.0, 1.0, -kInf, kInf}}, options);
  while (!strategy.stopped()) {
    for (const Individual& child : strategy.ask()) {
      for (std::size_t j = 0; j < 2; ++j) {
        ASSERT_TRUE(std::isfinite(child.y[j]));
        ASSERT_TRUE(std::isnormal(child.s[j]));
      }
    }
    strategy.tell(std::vector<double>(36, 1.0));
  }
}

TEST(EvolutionStrategyMutation, LearningRatesCanBeSet) {
  EvolutionStrategyOptions options = optionsOf(5);
  options.tau = 0.0;
  options.tau_prime = 0.0;
  EvolutionStrategy fixed(box(3, 0.0, 0.5), options);
  for (const Individual& child : fixed.ask()) EXPECT_EQ(child.s, std::vector<double>(3, 0.5));
  options.tau_prime = 0.3;
  EvolutionStrategy common(box(3, 0.0, 0.5), options);
  for (const Individual& child : common.ask()) {
    EXPECT_NE(child.s[0], 0.5);
    EXPECT_EQ(child.s, std::vector<double>(3, child.s[0]));
  }
}

// --- Selection ---

TEST(EvolutionStrategySelection, KeepsTheBestAndReplicatesThem) {
  EvolutionStrategy strategy(box(2, 0.0, 1.0), optionsOf(10));
  const std::vector<Individual> children = strategy.ask();
  strategy.tell(fitnessBut(9.0, {{30, 1.0}, {7, 2.0}, {12, 3.0}, {1, 4.0}, {35, 5.0}, {20, 6.0}}));
  const std::vector<Individual>& parents = strategy.state().parents;
  ASSERT_EQ(parents.size(), 6U);
  const std::size_t expected[] = {30, 7, 12, 1, 35, 20};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(parents[i].y, children[expected[i]].y);
    EXPECT_EQ(parents[i].s, children[expected[i]].s);
    EXPECT_EQ(parents[i].fitness, static_cast<double>(i + 1));
  }
  EvolutionStrategyOptions still = optionsOf(10);  // children that equal their parents show the descent
  still.tau = still.tau_prime = 0.0;
  EvolutionStrategyState state = strategy.state();
  for (Individual& parent : state.parents) parent.s = {1e-300, 1e-300};
  EvolutionStrategy copies(box(2, 0.0, 1.0), still, state);
  for (std::size_t k = 0; k < 36; ++k) EXPECT_EQ(copies.ask()[k].y, parents[k % 6].y);
}

TEST(EvolutionStrategySelection, TiesGoToTheLowerIndex) {
  EvolutionStrategy strategy(box(2, 0.0, 1.0), optionsOf(10));
  const std::vector<Individual> children = strategy.ask();
  strategy.tell(std::vector<double>(36, 1.0));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(strategy.state().parents[i].y, children[i].y);
}

TEST(EvolutionStrategySelection, InvalidIndividualsAreNotSelected) {
  EvolutionStrategy strategy(box(2, 0.0, 1.0), optionsOf(10));
  const std::vector<Individual> children = strategy.ask();
  strategy.tell(fitnessBut(kNan, {{3, -kInf}, {5, 2.0}, {6, kInf}, {8, 1.0}, {9, -kNan}}));
  const std::vector<Individual>& parents = strategy.state().parents;
  ASSERT_EQ(parents.size(), 2U) << "fewer than mu are kept as they are";
  EXPECT_EQ(parents[0].y, children[8].y);
  EXPECT_EQ(parents[1].y, children[5].y);

  EvolutionStrategyState state = strategy.state();
  EvolutionStrategyOptions still = optionsOf(10);
  still.tau = still.tau_prime = 0.0;
  for (Individual& parent : state.parents) parent.s = {1e-300, 1e-300};
  EvolutionStrategy copies(box(2, 0.0, 1.0), still, state);
  for (std::size_t k = 0; k < 36; ++k) EXPECT_EQ(copies.ask()[k].y, parents[k % 2].y) << "round robin";
}

TEST(EvolutionStrategySelection, CommaForgetsTheParentsAndBestIsKept) {
  EvolutionStrategy strategy(box(2, 0.0, 1.0), optionsOf(10));
  strategy.tell(fitnessBut(5.0, {{4, 1.0}}));
  const Individual best = strategy.state().best;
  EXPECT_EQ(best.fitness, 1.0);
  strategy.tell(std::vector<double>(36, 7.0));
  for (const Individual& parent : strategy.state().parents) EXPECT_EQ(parent.fitness, 7.0) << "worse, yet they replace";
  EXPECT_TRUE(sameBits(strategy.state().best, best));
  EXPECT_EQ(strategy.state().best_generation, 1);
  strategy.tell(fitnessBut(7.0, {{11, 0.5}}));
  EXPECT_EQ(strategy.state().best.fitness, 0.5);
  EXPECT_EQ(strategy.state().best_generation, 3);
}

// --- Termination ---

TEST(EvolutionStrategyStop, AfterTheLastGeneration) {
  EvolutionStrategy strategy(box(2, 1.0, 0.1), optionsOf(3));
  for (int g = 0; g < 3; ++g) {
    EXPECT_FALSE(strategy.stopped());
    step(strategy, sphere);
  }
  EXPECT_EQ(strategy.state().stop, StopReason::kMaxGenerations);
  EXPECT_STREQ(toString(strategy.state().stop), "max-generations");
  EXPECT_EQ(strategy.state().generation, 3);
}

TEST(EvolutionStrategyStop, AtOrBelowTheTarget) {
  EvolutionStrategyOptions options = optionsOf(10);
  options.target_fitness = 1.0;
  EvolutionStrategy strategy(box(2, 1.0, 0.1), options);
  strategy.tell(std::vector<double>(36, 1.0000001));
  EXPECT_FALSE(strategy.stopped());
  strategy.tell(fitnessBut(kNan, {{17, 1.0}}));
  EXPECT_EQ(strategy.state().stop, StopReason::kTargetFitness);
}

TEST(EvolutionStrategyStop, WithoutAValidIndividual) {
  EvolutionStrategy strategy(box(2, 1.0, 0.1), optionsOf(10));
  step(strategy, sphere);
  const EvolutionStrategyState before = strategy.state();
  strategy.tell(std::vector<double>(36, kInf));
  EXPECT_EQ(strategy.state().stop, StopReason::kNoValidIndividual);
  EXPECT_EQ(strategy.state().generation, 2);
  EXPECT_TRUE(sameBits(strategy.state().best, before.best)) << "the best is still there to be reported";
  EXPECT_TRUE(EvolutionStrategy(box(2, 1.0, 0.1), optionsOf(20), strategy.state()).stopped());
}

// --- Reproducibility ---

TEST(EvolutionStrategyBits, SameSeedSameRunOtherSeedOtherRun) {
  EvolutionStrategy a(box(5, 1.0, 0.1), optionsOf(30, 7)), b(box(5, 1.0, 0.1), optionsOf(30, 7));
  EvolutionStrategy c(box(5, 1.0, 0.1), optionsOf(30, 8));
  while (!a.stopped()) {
    ASSERT_TRUE(sameBits(a.ask(), b.ask()));
    ASSERT_FALSE(sameBits(a.ask(), c.ask()));
    for (EvolutionStrategy* strategy : {&a, &b, &c}) step(*strategy, sphere);
  }
  EXPECT_TRUE(sameBits(a.state(), b.state()));
}

TEST(EvolutionStrategyBits, AskingTwiceChangesNothing) {
  EvolutionStrategy strategy(box(5, 1.0, 0.1), optionsOf(30));
  step(strategy, sphere);
  const EvolutionStrategyState before = strategy.state();
  const std::vector<Individual> first = strategy.ask();
  EXPECT_TRUE(sameBits(first, strategy.ask()));
  EXPECT_TRUE(sameBits(before, strategy.state()));
  EXPECT_TRUE(std::isnan(first[0].fitness));
}

TEST(EvolutionStrategyBits, ResumesAnywhere) {
  constexpr int kGenerations = 25;
  const Objective partly_invalid = [](const std::vector<double>& y) { return y[0] > 1.05 ? kNan : ellipsoid(y); };
  EvolutionStrategy whole(box(5, 1.0, 0.1), optionsOf(kGenerations));
  std::vector<EvolutionStrategyState> states = {whole.state()};
  while (!whole.stopped()) {
    step(whole, partly_invalid);
    states.push_back(whole.state());
  }
  ASSERT_EQ(states.size(), kGenerations + 1U);
  for (const EvolutionStrategyState& state : states) {
    EvolutionStrategy resumed(box(5, 1.0, 0.1), optionsOf(kGenerations), state);
    while (!resumed.stopped()) step(resumed, partly_invalid);
    EXPECT_TRUE(sameBits(resumed.state(), whole.state())) << "from generation " << state.generation;
  }
  EvolutionStrategy longer(box(5, 1.0, 0.1), optionsOf(kGenerations + 1), whole.state());
  EXPECT_FALSE(longer.stopped()) << "a finished run can be given more generations";
}

// --- Refusals ---

std::string errorOf(const std::vector<ObjectParameter>& parameters, const EvolutionStrategyOptions& options) {
  try {
    EvolutionStrategy strategy(parameters, options);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(EvolutionStrategyRefuses, BadOptions) {
  const auto with = [](const auto& change) {
    EvolutionStrategyOptions options;
    change(options);
    return errorOf(box(2, 0.0, 1.0), options);
  };
  using Options = EvolutionStrategyOptions;
  EXPECT_EQ(with([](Options&) {}), "accepted");
  EXPECT_EQ(with([](Options& o) { o.mu = 0; }), "evolution strategy: mu = 0 is not an integer >= 1");
  EXPECT_EQ(with([](Options& o) { o.lambda = 5; }), "evolution strategy: lambda = 5 is not an integer >= mu = 6");
  EXPECT_EQ(with([](Options& o) { o.generations = 0; }), "evolution strategy: generations = 0 is not an integer >= 1");
  EXPECT_EQ(with([](Options& o) { o.tau = -1.0; }), "evolution strategy: tau = -1 is not a finite number >= 0");
  EXPECT_EQ(with([](Options& o) { o.tau_prime = kInf; }),
            "evolution strategy: tau_prime = inf is not a finite number >= 0");
  EXPECT_EQ(with([](Options& o) { o.target_fitness = kNan; }),
            "evolution strategy: target_fitness = nan is not a number");
}

TEST(EvolutionStrategyRefuses, BadParameters) {
  const auto with = [](const ObjectParameter& parameter) {
    return errorOf({{0.0, 1.0, -1.0, 1.0}, parameter}, EvolutionStrategyOptions{});
  };
  EXPECT_EQ(errorOf({}, {}), "evolution strategy: there is no parameter to search for");
  EXPECT_EQ(with({0.0, 1.0, -kInf, kInf}), "accepted");
  EXPECT_EQ(with({2.0, 1.0, 0.0, 1.0}), "parameter 1: initial value 2 is outside [0, 1]");
  EXPECT_EQ(with({kNan, 1.0, 0.0, 1.0}), "parameter 1: initial value nan is outside [0, 1]");
  EXPECT_EQ(with({kInf, 1.0, 0.0, kInf}), "parameter 1: initial value inf is outside [0, inf]");
  EXPECT_EQ(with({0.0, 1.0, 1.0, -1.0}), "parameter 1: lower bound 1 exceeds upper bound -1");
  EXPECT_EQ(with({0.0, 0.0, -1.0, 1.0}), "parameter 1: step 0 is not a finite number > 0");
  EXPECT_EQ(with({0.0, kNan, -1.0, 1.0}), "parameter 1: step nan is not a finite number > 0");
}

TEST(EvolutionStrategyRefuses, StatesOfAnotherProblem) {
  EvolutionStrategy strategy(box(3, 0.0, 1.0), optionsOf(10));
  step(strategy, sphere);
  const EvolutionStrategyState state = strategy.state();
  EXPECT_THROW(EvolutionStrategy(box(4, 0.0, 1.0), optionsOf(10), state), ConfigError);
  EvolutionStrategyOptions fewer = optionsOf(10);
  fewer.mu = 5;
  EXPECT_THROW(EvolutionStrategy(box(3, 0.0, 1.0), fewer, state), ConfigError);
  EXPECT_THROW(EvolutionStrategy(box(3, 0.0, 1.0), optionsOf(10), EvolutionStrategyState{}), ConfigError);
}

}  // namespace
}  // namespace simgap
