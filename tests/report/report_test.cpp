#include "simgap/report/poses/pose_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "report/known_results.h"
#include "report/poses/pose_tables.h"

namespace simgap {
namespace {

using test::knownCalibration;
using test::knownValidation;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> keysOf(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  return keys;
}

TEST(CalibrateReport, ResultHasTheFieldsOtherProgramsRead) {
  const Json json = toJson(knownCalibration());
  EXPECT_EQ(json.at("format"), "simgap/calibrate/1");
  EXPECT_THAT(keysOf(json.at("mje_deg")), ElementsAre("calibration", "validation"));
  EXPECT_NEAR(json.at("mje_deg").at("calibration").at("initial").at("shoulder").get<double>(), 20.0, 1e-12);
  EXPECT_NEAR(json.at("mje_deg").at("calibration").at("final").at("elbow").get<double>(), 1.0, 1e-12);
  EXPECT_NEAR(json.at("paper_mje_deg").at("calibration").at("initial").at("shoulder").get<double>(), 10.0, 1e-12);
  EXPECT_NEAR(json.at("fitness").at("initial").get<double>(), 2 * (400 + 100) * kDegree * kDegree, 1e-12);
  EXPECT_NEAR(json.at("fitness").at("final").get<double>(), 2 * (4 + 1) * kDegree * kDegree, 1e-12);
  EXPECT_EQ(json.at("generations"), 2);
  EXPECT_EQ(json.at("evaluations"), 2 * 8 * 2);
  EXPECT_EQ(json.at("invalid"), 5);
  EXPECT_EQ(json.at("wall_s"), 1.5);
  EXPECT_EQ(json.at("stop_reason"), "max-generations");
  ASSERT_EQ(json.at("parameters").size(), 2u);
  const Json& first = json.at("parameters")[0];
  for (const char* key : {"name", "unit", "initial", "value", "lower", "upper", "at_bound", "identifiable"}) {
    EXPECT_TRUE(first.contains(key)) << key;
  }
  EXPECT_EQ(first.at("value"), 1.0);
  EXPECT_EQ(first.at("at_bound"), true);
  EXPECT_TRUE(json.at("parameters")[1].at("lower").is_null());  // -infinity
  EXPECT_EQ(json.at("parameters")[1].at("at_bound"), false);
}

TEST(CalibrateReport, LeavesOutTheValidationThatWasNotGiven) {
  CalibrationResult result = knownCalibration();
  result.sets.pop_back();
  EXPECT_THAT(keysOf(toJson(result).at("mje_deg")), ElementsAre("calibration"));
}

TEST(CalibrateReport, WhatIsUnknownIsNull) {
  const Json json = toJson(knownCalibration());
  const Json& validation = json.at("mje_deg").at("validation");
  EXPECT_TRUE(validation.at("initial").at("shoulder").is_null());
  EXPECT_EQ(toText(json).find("nan"), std::string::npos);
  CalibrationResult result = knownCalibration();
  std::swap(result.sets[0], result.sets[1]);
  EXPECT_TRUE(toJson(result).at("fitness").at("initial").is_null());
}

TEST(CalibrateReport, TablesReadBackAsCsv) {
  const CalibrationResult result = knownCalibration();
  const CsvTable history = CsvTable::parse(historyCsv(result), "history.csv");
  EXPECT_EQ(history.rows(), 2u);
  EXPECT_THAT(history.quantity("generation", ""), ElementsAre(1, 2));
  EXPECT_THAT(history.quantity("best_rad2", ""), ElementsAre(0.5, 0.25));
  EXPECT_THAT(history.quantity("invalid", ""), ElementsAre(3, 2));
  EXPECT_NEAR(history.quantity("mje_elbow", "rad")[1], kDegree, 1e-15);
  const CsvTable parameters = CsvTable::parse(parametersCsv(result), "parameters.csv");
  EXPECT_THAT(parameters.text("name"), ElementsAre("muscles.biceps.stiffness", "joints.elbow.friction"));
  EXPECT_THAT(parameters.quantity("value", ""), ElementsAre(1.0, 0.3));
  EXPECT_THAT(parameters.text("lower"), ElementsAre("1", ""));
  EXPECT_THAT(parameters.text("at_bound"), ElementsAre("true", "false"));
  const CsvTable errors = CsvTable::parse(errorsCsv(result), "errors.csv");
  EXPECT_EQ(errors.rows(), 3u);
  EXPECT_THAT(errors.text("set"), ElementsAre("calibration", "calibration", "validation"));
  EXPECT_THAT(errors.text("pose"), ElementsAre("low", "a,\"b\"", "<far>"));
  EXPECT_THAT(errors.text("status_before"), ElementsAre("steady", "steady", "acquisition error"));
  EXPECT_THAT(errors.text("shoulder_error_before_deg")[2], "");
  EXPECT_NEAR(std::stod(errors.text("shoulder_error_after_deg")[0]), 2.0, 1e-12);
}

TEST(CalibrateReport, PrintsATableForTheTerminal) {
  EXPECT_EQ(terminalTable(knownCalibration()),
            "mean joint error [deg]      shoulder before   after  elbow before   after\n"
            "calibration (2 of 2 poses)            20.00    2.00         10.00    1.00\n"
            "  as half angles (paper)              10.00    1.00         10.00    1.00\n"
            "validation (1 of 1 poses)                 -    3.00             -    4.00\n"
            "  as half angles (paper)                  -    1.50             -    4.00\n"
            "  at rest                            0 of 1  1 of 1        0 of 1  1 of 1\n");
  CalibrationResult result = knownCalibration();
  result.sets[1].final = result.sets[1].initial;
  result.parameters.resize(9, result.parameters[0]);  // 2 poses x (3 + 1) numbers
  result.state.strategy.best.y.resize(9, 1.0);
  EXPECT_THAT(terminalTable(result),
              HasSubstr("\nvalidation pose <far>: acquisition error of biceps, 12.3 deg\n8 measured "
                        "numbers for 9 parameters: the calibration error alone proves nothing"));
}

TEST(CalibrateReport, SaysWhatThePosesTellAndWhatToExpect) {
  CalibrationResult result = knownCalibration();
  EXPECT_FALSE(toJson(result).contains("identifiability")) << "nothing is known of it";
  EXPECT_TRUE(toJson(result).at("parameters")[0].at("identifiable").is_null());
  result.uncertainty = PoseUncertainty{};
  result.uncertainty->parameters = {{100.0, 20.0, Verdict::kIdentifiable},
                                    {INFINITY, INFINITY, Verdict::kNotIdentifiable}};
  result.uncertainty->singular_values = {30.0, 0.5};
  result.uncertainty->combinations = {{{0, 1}, true, "a and b: only their sum"}};
  result.uncertainty->distances = {1.0, 12.0};
  result.sets[1].predicted = PredictedError{{2 * kDegree, kDegree}, {kDegree, kDegree}, {3.5 * kDegree, 2 * kDegree}};
  const Json json = toJson(result);
  EXPECT_EQ(json.at("parameters")[0].at("identifiable"), "identifiable");
  EXPECT_EQ(json.at("parameters")[0].at("sd"), 20.0);
  EXPECT_TRUE(json.at("parameters")[1].at("sd").is_null());
  EXPECT_EQ(json.at("outlying_poses")[0].at("pose"), "a,\"b\"");
  EXPECT_EQ(json.at("combinations")[0].at("parameters")[1], "joints.elbow.friction");
  EXPECT_NEAR(json.at("predicted_mje_deg").at("validation").at("shoulder").at("ci90")[1].get<double>(), 3.5, 1e-12);
  const std::string text = uncertaintyText(json);
  EXPECT_THAT(text, HasSubstr("1 identifiable, 0 weak, 1 not identifiable\n  a and b: only their sum\n"));
  EXPECT_THAT(terminalTable(result), HasSubstr(text));
  EXPECT_THAT(terminalTable(result), HasSubstr("the elbow misses by 4.00° where at most 2.00° was to be expected"));
  EXPECT_THAT(terminalTable(result), HasSubstr("hardly counted: a,\"b\" (12.0 sd)"));
  EXPECT_THAT(predictionTable(json).header,
              ElementsAre("poses", "shoulder predicted", "found", "elbow predicted", "found"));
  EXPECT_THAT(predictionTable(json).rows.back(),
              ElementsAre("validation", "2.00 (1.00 to 3.50)", "3.00", "1.00 (1.00 to 2.00)", "4.00"));
}

TEST(CalibrateReport, SaysHowFarSearcherAndJudgeDisagree) {
  CalibrationResult result = knownCalibration();
  EXPECT_FALSE(toJson(result).contains("verification"));
  Assessment searched = result.sets[0].final;
  for (PoseOutcome& outcome : result.sets[0].final.outcomes) outcome.joints.resize(2);
  for (PoseOutcome& outcome : searched.outcomes) {
    outcome.joints.resize(2);
    outcome.joints[1].angle = 0.5 * kDegree;
  }
  searched.outcomes[0].joints[1].angle = 1.5 * kDegree;
  result.config.evaluator = "equilibrium";
  result.sets[0].searched = searched;
  const Json difference = toJson(result).at("verification").at("sets").at("calibration").at("difference_deg");
  EXPECT_NEAR(difference.at("mean").at("elbow").get<double>(), 1.0, 1e-9);
  EXPECT_NEAR(difference.at("largest").at("elbow").get<double>(), 1.5, 1e-9);
  EXPECT_EQ(difference.at("mean").at("shoulder"), 0.0);
  EXPECT_THAT(verificationTable(toJson(result)).rows.front(),
              ElementsAre("calibration", "2.00", "0.00", "0.00", "1.00", "1.00", "1.50"));
}

TEST(CalibrateReport, BlamesNotTheModelWhereItsTwoSimulationsRestApart) {
  // The elbow misses by 4 deg where 2 were expected; Bullet and the equilibrium of the same model lie 1 and 3 apart.
  CalibrationResult result = knownCalibration();
  result.uncertainty = PoseUncertainty{};
  result.uncertainty->parameters = {{100.0, 20.0, Verdict::kWeak}, {1.0, 1.0, Verdict::kWeak}};
  result.config.evaluator = "equilibrium";
  SetResult& unseen = result.sets[1];
  unseen.predicted = PredictedError{{kDegree, kDegree}, {kDegree, kDegree}, {3.5 * kDegree, 2 * kDegree}};
  const auto notes = [&](double apart) {
    for (SetResult& set : result.sets) {
      for (PoseOutcome& outcome : set.final.outcomes) {
        outcome.joints.resize(2);
        outcome.status = PoseStatus::kSteady;
      }
      set.searched = set.final;
      for (PoseOutcome& outcome : set.searched->outcomes) outcome.joints[1].angle = apart;
    }
    return surprises(toJson(result));
  };
  ASSERT_EQ(notes(kDegree).size(), 1u);
  EXPECT_THAT(notes(kDegree)[0], HasSubstr("was to be expected: something is not in the model."));
  ASSERT_EQ(notes(3 * kDegree).size(), 1u);
  EXPECT_THAT(notes(3 * kDegree)[0],
              AllOf(HasSubstr("bullet comes to rest elsewhere"), Not(HasSubstr("not in the model"))));
}

TEST(ValidateReport, ResultHasTheFieldsOtherProgramsRead) {
  const Json json = toJson(knownValidation());
  EXPECT_EQ(json.at("format"), "simgap/validate/1");
  EXPECT_NEAR(json.at("mje_deg").at("shoulder").get<double>(), 20.0, 1e-12);
  EXPECT_NEAR(json.at("paper_mje_deg").at("shoulder").get<double>(), 10.0, 1e-12);
  EXPECT_NEAR(json.at("paper_mje_deg").at("elbow").get<double>(), 10.0, 1e-12);
  ASSERT_EQ(json.at("poses").size(), 3u);
  EXPECT_EQ(json.at("poses")[0].at("pose"), "low");
  EXPECT_NEAR(json.at("poses")[0].at("error_deg").at("elbow").get<double>(), 10.0, 1e-12);
  EXPECT_TRUE(json.at("poses")[2].at("error_deg").is_null());
  ASSERT_EQ(json.at("criteria").size(), 2u);
  EXPECT_EQ(json.at("criteria")[0].at("pass"), true);
  EXPECT_EQ(json.at("criteria")[1].at("pass"), false);
  EXPECT_TRUE(json.at("criteria")[1].at("value").is_null());
  EXPECT_EQ(CsvTable::parse(errorsCsv(knownValidation()), "errors.csv").text("status"),
            (std::vector<std::string>{"steady", "steady", "acquisition error"}));
}

TEST(ValidateReport, PrintsATableForTheTerminalWithTheWorstFirst) {
  ValidationResult result = knownValidation();
  result.criteria.clear();
  EXPECT_EQ(terminalTable(result),
            "                                      shoulder  elbow\n"
            "mean joint error [deg], 2 of 3 poses     20.00  10.00\n"
            "  as half angles (paper)                 10.00  10.00\n"
            "\n"
            "worst poses\n"
            "pose   shoulder  elbow             status  slack muscles\n"
            "<far>         -      -  acquisition error\n"
            "low       20.00  10.00             steady\n"
            "a,\"b\"     20.00  10.00             steady\n"
            "<far>: acquisition error of biceps, 12.3 deg\n");
}

}  // namespace
}  // namespace simgap
