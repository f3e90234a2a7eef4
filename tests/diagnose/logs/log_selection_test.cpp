#include "diagnose/logs/log_selection.h"

#include <gtest/gtest.h>

#include "diagnose/logs/held_out.h"
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
