#include "diagnose/logs/log_selection.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "diagnose/logs/held_out.h"
#include "diagnose/verdict.h"
#include "prepared_logs.h"
#include "reality/spring_rig.h"
#include "simgap/fit/actuators/actuator_model.h"

namespace simgap::test {
namespace {

const std::vector<Hypothesis>& hypotheses() {
  static const std::vector<Hypothesis> list = {{&actuator_effects::find("inertia"), {}, {}},
                                               {&actuator_effects::find("current-bias"), {}, {}},
                                               {&actuator_effects::find("bend-friction"), {}, {}}};
  return list;
}

Selection select(const reality::DriveSecret& secret) {
  const PreparedLog log = preparedLog(smallRig(6000), secret);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("classic"), log.data, splitLog(log, options).training, options);
  return selectCauses(search, {}, hypotheses(), {}, options, {});  // its models outlive their data, unused
}

TEST(LogSelection, PicksTheHiddenCauseAndRecordsEveryTrial) {
  reality::DriveSecret secret;
  secret.current_bias = 0.5;
  const Selection selection = select(secret);
  ASSERT_EQ(selection.p_adjusted.size(), 1u);
  EXPECT_LT(selection.p_adjusted[0], 0.05);
  EXPECT_TRUE(selection.ambiguous_with[0].empty());
  EXPECT_EQ(selection.steps.size(), 2u);
  EXPECT_LT(selection.chosen.mse, selection.baseline.mse);
  ASSERT_EQ(selection.records.size(), 3u + 2u);  // three, then the two that are left
  EXPECT_EQ(selection.records[1].effect, "current-bias");
  EXPECT_EQ(selection.records[1].outcome, "accepted");
  EXPECT_EQ(selection.records[0].outcome.substr(0, 8), "rejected");
}

TEST(LogSelection, PicksNothingWhereNothingIsHidden) {
  const Selection selection = select({});
  EXPECT_TRUE(selection.p_adjusted.empty());
  EXPECT_EQ(selection.steps.size(), 1u);
  EXPECT_EQ(selection.chosen.mse, selection.baseline.mse);
}

/// A joint that lifts a weight nobody knows of with friction that falls as it warms up, for less than a minute.
PreparedLog weightAndHeat(int seed, int rows, double weight) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<> phase(0.0, 2.0 * std::numbers::pi);
  std::normal_distribution<> noise(0.0, 0.04);
  std::array<double, 6> phases;
  for (double& p : phases) p = phase(random);
  std::string text = "time_s,motor_position_rad,motor_velocity_rad_s,motor_current_A,temperature_degC\n";
  for (int i = 0; i < rows; ++i) {
    const double t = 0.02 * i;
    double q = 0.0, w = 0.0;
    for (int k = 0; k < 5; ++k) {
      q += 0.3 * std::sin(0.35 * (k + 1) * t + phases[k]);
      w += 0.105 * (k + 1) * std::cos(0.35 * (k + 1) * t + phases[k]);
    }
    const double warm = 30.0 + 10.0 * std::sin(9.42 * i / rows + phases[5]);
    const double friction = (0.3 * std::tanh(w / 0.01) + 0.4 * w) / (1.0 + 0.05 * (warm - 28.0));
    text += fmt::format("{},{},{},{},{}\n", t, q, w, friction + weight * std::sin(q - 0.6) + noise(random), warm);
  }
  Bench bench;
  bench.load = BenchLoad::kFreeAxis;
  bench.inertia = {.fitted = true};
  bench.bandwidth = 5.0;
  return prepareLog(CsvTable::parse(text, "log.csv"), bench, ActuatorKind::kFriction);
}

TEST(LogSelection, TwoCausesThatHideEachOtherAreFoundTogether) {
  const std::vector<Hypothesis> both = {{&actuator_effects::find("joint-gravity"), {}, {}},
                                        {&actuator_effects::find("friction-heating"), {}, {}}};
  for (const int seed : {3, 7}) {
    const PreparedLog log = weightAndHeat(seed, 1000, 0.3);
    LogDiagnosisOptions options;
    const LogSearch search(friction::find("coulomb"), log.data, splitLog(log, options).training, options);
    options.max_causes = 1;
    EXPECT_TRUE(selectCauses(search, {}, both, {}, options, {}).p_adjusted.empty()) << "each alone is not significant";
    options.max_causes = 2;
    EXPECT_EQ(selectCauses(search, {}, both, {}, options, {}).p_adjusted.size(), 2u);
  }
}

TEST(LogSelection, ReviewPutsABetterRivalInACausesPlace) {
  reality::DriveSecret secret;
  secret.current_bias = 0.5;
  const PreparedLog log = preparedLog(smallRig(6000), secret);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("classic"), log.data, splitLog(log, options).training, options);
  Selection selection;
  selection.baseline = search.fit({}, nullptr);
  search.validate(selection.baseline);
  selection.chosen = search.fit({&actuator_effects::find("bend-friction")}, &selection.baseline);
  selection.p_adjusted = {0.01};
  selection.ambiguous_with.resize(1);
  selection.instead.resize(1);
  reviewCauses(search, 0, hypotheses(), options, selection);
  ASSERT_EQ(selection.chosen.model->effects().size(), 1u);
  EXPECT_EQ(selection.chosen.model->effects()[0]->name, "current-bias");
  ASSERT_EQ(selection.steps.size(), 2u);
  EXPECT_LT(selection.steps[1].mse, 0.5 * selection.baseline.mse);
}

TEST(LogSelection, ReviewPutsTheSimplestOfThoseThatDataCannotTellApartFirst) {
  reality::SpringTruth truth;
  truth.curve = {{-1.0, -210.0}, {0.0, 0.0}, {1.0, 150.0}};
  const PreparedLog log = prepareLog(CsvTable::parse(reality::recordSpring(truth, {.seed = 4}).csv(), "log.csv"), {},
                                     ActuatorKind::kSpring);
  const std::vector<Hypothesis> sides = {{&actuator_effects::find("spring-hardening"), {}, {}},
                                         {&actuator_effects::find("spring-direction"), {}, {}}};
  LogDiagnosisOptions options;
  options.level = 1e-30;  // nothing is told apart by errors at this level
  const LogSearch search(subjectOf("spring").base, log.data, splitLog(log, options).training, options);
  Selection selection;
  selection.baseline = search.fit({}, nullptr);
  search.validate(selection.baseline);
  selection.chosen = search.tryAll(selection.baseline, sides)[0].fitted;
  selection.p_adjusted = {0.01};
  selection.ambiguous_with.resize(1);
  selection.instead.resize(1);
  reviewCauses(search, 0, sides, options, selection);
  EXPECT_EQ(selection.chosen.model->effects()[0]->name, "spring-direction");
}

TEST(LogSelection, DetectionFactorHasAFloor) {
  EXPECT_DOUBLE_EQ(detectionFactor(0.015, 100.0), 4.6);
  EXPECT_DOUBLE_EQ(detectionFactor(0.01, 1e4), 10.0);
}

}  // namespace
}  // namespace simgap::test
