#include "simgap/report/runs/run_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/result_folder.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

using ::testing::HasSubstr;

RunFigures fitted(const std::string& name, double friction, double inertia = 2.0) {
  RunFigures run;
  run.name = name;
  run.format = "simgap/fit-friction/1";
  run.subject = "classic";
  run.data = {name};
  run.errors = {{"mse", friction}};
  run.parameters = {{"tau_c", "Nm", {friction, 0.1}}, {"j", "kg_m2", {inertia, 0.1}}};
  return run;
}

TEST(CompareRuns, SilentWhereNothingDiffers) {
  const Json result = compareRuns({fitted("a", 1.0), fitted("b", 1.05), fitted("c", 0.96)});
  EXPECT_EQ(result.at("format"), "simgap/compare/1");
  for (const Json& p : result.at("parameters")) EXPECT_EQ(p.at("verdict"), "same");
  EXPECT_THAT(comparisonAnswer(result), HasSubstr("none of 2 parameters differs"));
  EXPECT_TRUE(result.at("warnings").empty());
}

TEST(CompareRuns, NamesWhatChangedSinceWhenAndByHowMuch) {
  const Json result = compareRuns({fitted("d1", 1.0), fitted("d2", 1.05), fitted("d3", 0.96), fitted("d4", 1.01),
                                   fitted("d5", 2.02), fitted("d6", 1.97), fitted("d7", 2.0), fitted("d8", 2.03)});
  const Json& friction = result.at("parameters")[0];
  EXPECT_EQ(friction.at("verdict"), "changed");
  EXPECT_EQ(friction.at("change").at("since"), "d5");
  EXPECT_NEAR(friction.at("change").at("step").get<double>(), 1.0, 0.05);
  EXPECT_EQ(result.at("parameters")[1].at("verdict"), "same");
  EXPECT_THAT(comparisonAnswer(result), HasSubstr("tau_c changed by +1 N m since d5"));
}

TEST(CompareRuns, NamesWhatDriftsAndByHowMuch) {
  std::vector<RunFigures> runs;
  for (int i = 0; i < 8; ++i)
    runs.push_back(fitted(std::string("d") + std::to_string(i), 1.0 + 0.3 * i + 0.05 * (i % 3)));
  const Json result = compareRuns(runs);
  const Json& friction = result.at("parameters")[0];
  EXPECT_EQ(friction.at("verdict"), "drifts");
  EXPECT_NEAR(friction.at("drift").at("per_run").get<double>(), 0.3, 0.02);
  EXPECT_TRUE(friction.at("change").is_null());
  EXPECT_THAT(comparisonAnswer(result), HasSubstr("tau_c drifts by +0.3"));
}

TEST(CompareRuns, ScatterIsNoChange) {
  const Json result = compareRuns(
      {fitted("a", 1.0), fitted("b", 3.0), fitted("c", 1.2), fitted("d", 2.7), fitted("e", 0.9), fitted("f", 2.9)});
  EXPECT_EQ(result.at("parameters")[0].at("verdict"), "differs");
  EXPECT_TRUE(result.at("parameters")[0].at("change").is_null());
}

TEST(CompareRuns, WarnsOfTheSameDataAndOfOtherLaws) {
  RunFigures again = fitted("b", 1.0), other = fitted("c", 1.0);
  again.data = {"a"};
  other.subject = "stribeck";
  const Json result = compareRuns({fitted("a", 1.0), again, other});
  ASSERT_EQ(result.at("warnings").size(), 2u);
  EXPECT_THAT(result.at("warnings")[0].get<std::string>(), HasSubstr("a and b read the same data"));
  EXPECT_THAT(result.at("warnings")[1].get<std::string>(), HasSubstr("c fits stribeck"));
}

TEST(CompareRuns, RefusesRunsOfDifferentCommands) {
  RunFigures other = fitted("b", 1.0);
  other.format = "simgap/validate/1";
  EXPECT_THROW(compareRuns({fitted("a", 1.0), other}), DataError);
}

const Json kDiagnosis = {
    {"format", "simgap/diagnose/1"},
    {"verdict", "cause-found"},
    {"baseline", {{"mse", 0.2}}},
    {"causes",
     {{{"effect", "bend-friction"},
       {"gain_heldout_percent", 40.0},
       {"parameters", {{{"name", "b"}, {"unit", "1_rad"}, {"value", 0.2}, {"ci95", {0.1, 0.3}}}}}}}}};

// A friction's speed that several valleys fit: its interval reaches further than its curvature, to one side.
TEST(ReadRun, AnIntervalThatReachesFurtherThanTheCurvatureCounts) {
  const test::ResultFolder folder(
      Json{{"format", "simgap/fit-friction/1"},
           {"parameters",
            {{{"name", "v_s"}, {"unit", "rad_s"}, {"value", 8.0}, {"sd", 0.5}, {"ci95", {0.16, 8.98}}},
             {{"name", "k_v"}, {"unit", "Nms_rad"}, {"value", 1.0}, {"sd", 0.1}, {"ci95", {nullptr, nullptr}}}}}});
  const RunFigures run = readRun(folder.directory().path());
  ASSERT_EQ(run.parameters.size(), 2u);
  EXPECT_NEAR(run.parameters[0].estimate.sd, (8.0 - 0.16) / 1.96, 1e-3);
  EXPECT_EQ(run.parameters[1].estimate.sd, 0.1);
}

TEST(ReadRun, TakesErrorsCausesAndIntervals) {
  const test::ResultFolder folder(kDiagnosis);
  const RunFigures run = readRun(folder.directory().path());
  EXPECT_EQ(run.verdict, "cause-found");
  ASSERT_EQ(run.errors.size(), 1u);
  EXPECT_EQ(run.errors[0].first, "baseline.mse");
  ASSERT_EQ(run.causes.size(), 1u);
  EXPECT_EQ(run.causes[0].magnitude, "b 0.2");
  ASSERT_EQ(run.parameters.size(), 1u);
  EXPECT_EQ(run.parameters[0].name, "bend-friction.b");
  EXPECT_NEAR(run.parameters[0].estimate.sd, 0.1 / 1.96, 1e-4);
}

TEST(ReadRun, RefusesWhatSimgapNeverWrites) {
  const test::ResultFolder folder(Json{{"format", "simgap/fit/1"}, {"parameters", {{{"value", "much"}}}}});
  EXPECT_THROW(readRun(folder.directory().path()), DataError);
}

TEST(ComparePage, HasAChartPerParameter) {
  const test::ResultFolder folder(compareRuns({fitted("a", 1.0), fitted("b", 3.0)}));
  const Page page = folder.page();
  EXPECT_THAT(page.answer, HasSubstr("1 of 2 parameters differ"));
  EXPECT_EQ(page.sections.front().blocks.size(), 2u);
}

}  // namespace
}  // namespace simgap
