#include "simgap/fit/poses/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simgap/fit/poses/calibration_run.h"
#include "simgap/model/arm/arm_yaml.h"
#include "support/analytic_evaluator.h"
#include "support/files.h"
#include "support/rig.h"

namespace simgap {
namespace {

using test::analyticArm;
using test::analyticConfig;
using test::AnalyticEvaluator;
using ::testing::HasSubstr;

const std::vector<Pose>& poses() {
  static const std::vector<Pose> kPoses = test::analyticPoses();
  return kPoses;
}

double line(const ArmModel& model, std::size_t muscle) { return model.muscles[muscle].kite_line_length; }

/// The exact fitness of the analytic arm: elbow and shoulder are off by the same amount in both poses.
double fitnessOf(double biceps, double triceps) {
  return 2 * ((biceps - 0.3) * (biceps - 0.3) + (triceps - 0.1) * (triceps - 0.1));
}

/// Everything of a state but the time it took.
std::string textOf(CalibrationState state) {
  state.wall = 0.0;
  return toText(toJson(state));
}

void fail(PoseOutcome& outcome, PoseStatus status, int worst, double value) {
  outcome = {};
  outcome.status = status;
  outcome.worst = worst;
  outcome.worst_value = value;
}

TEST(Calibration, FindsTheParametersAndKeepsItsHistory) {
  AnalyticEvaluator evaluator;
  CalibrationConfig config = analyticConfig();
  config.strategy.generations = 60;
  Calibration calibration(analyticArm(), poses(), config, evaluator);
  EXPECT_EQ(writeArm(calibration.bestModel()), writeArm(analyticArm()));
  int calls = 0;
  calibration.run([&](const CalibrationState& state) {
    EXPECT_EQ(state.strategy.generation, ++calls);
    EXPECT_EQ(static_cast<int>(state.history.size()), calls);
  });
  EXPECT_EQ(calls, 60);
  const CalibrationState& state = calibration.state();
  EXPECT_EQ(state.strategy.stop, StopReason::kMaxGenerations);
  EXPECT_EQ(state.invalid, 0);
  EXPECT_NEAR(line(calibration.bestModel(), 0), 0.3, 1e-3);
  EXPECT_NEAR(line(calibration.bestModel(), 1), 0.1, 1e-3);
  double best = INFINITY;
  for (const GenerationRecord& r : state.history) {
    best = std::min(best, r.best);
    EXPECT_EQ(r.best_so_far, best);
    EXPECT_LE(r.best, r.median);
    EXPECT_LE(r.sigma_min, r.sigma_median);
    EXPECT_LE(r.sigma_median, r.sigma_max);
    ASSERT_EQ(r.mje.size(), 2u);
    // Both poses are off by the same, so the fitness of I_best follows from its mean errors.
    EXPECT_NEAR(2 * (r.mje[0] * r.mje[0] + r.mje[1] * r.mje[1]), r.best_so_far, 1e-12);
  }
  EXPECT_EQ(state.strategy.best.fitness, best);
  EXPECT_NEAR(fitnessOf(line(calibration.bestModel(), 0), line(calibration.bestModel(), 1)), best, 1e-12);
  EXPECT_EQ(state.best_mje, state.history.back().mje);
}

TEST(Calibration, StopsAtTheTargetAndKeepsToItsRange) {
  AnalyticEvaluator evaluator;
  CalibrationConfig config = analyticConfig();
  config.strategy.generations = 500;
  config.strategy.target_fitness = fitnessOf(0.25, 0.1) * 1.01;
  config.parameters[0].upper = 0.25;
  Calibration calibration(analyticArm(), poses(), config, evaluator);
  calibration.run([](const CalibrationState&) {});
  EXPECT_EQ(calibration.state().strategy.stop, StopReason::kTargetFitness);
  EXPECT_LT(calibration.state().strategy.generation, 500);
  EXPECT_LE(line(calibration.bestModel(), 0), 0.25);
}

TEST(Calibration, CountsInvalidIndividualsAndNeverKeepsOne) {
  // The best region is poisoned: whoever comes near it blows up in the second pose.
  AnalyticEvaluator evaluator([](const ArmModel& model, std::size_t pose, PoseOutcome& outcome) {
    if (pose == 1 && line(model, 0) > 0.2) fail(outcome, PoseStatus::kNotFinite, -1, -1.0);
  });
  Calibration calibration(analyticArm(), poses(), analyticConfig(), evaluator);
  calibration.run([](const CalibrationState&) {});
  const CalibrationState& state = calibration.state();
  long invalid = 0;
  for (const GenerationRecord& r : state.history) {
    EXPECT_GE(r.invalid, 0);
    EXPECT_LT(r.invalid, 12);
    EXPECT_TRUE(std::isfinite(r.best) && std::isfinite(r.median));
    invalid += r.invalid;
  }
  EXPECT_GT(invalid, 0);
  EXPECT_EQ(state.invalid, invalid);
  EXPECT_LE(line(calibration.bestModel(), 0), 0.2);
}

TEST(Calibration, SaysWhyNoIndividualIsValid) {
  int individual = 0;
  AnalyticEvaluator evaluator([&](const ArmModel&, std::size_t pose, PoseOutcome& outcome) {
    if (pose == 1) return;  // skipped: the first pose is invalid already
    const int k = individual++;
    if (k < 5) fail(outcome, PoseStatus::kAcquisitionError, k % 2, (10 + k) * kDegree);
    if (k >= 5 && k < 9) fail(outcome, PoseStatus::kNotSteady, 1, 0.1 * k);
    if (k >= 9) fail(outcome, PoseStatus::kNotFinite, -1, -1.0);
  });
  Calibration calibration(analyticArm(), poses(), analyticConfig(), evaluator);
  int stored = 0;
  const std::string error = test::errorOf([&] { calibration.run([&](const CalibrationState&) { ++stored; }); });
  EXPECT_EQ(
      error.substr(0, error.find(';')),
      "4: no valid individual in generation 1: 5 x acquisition error (worst: acquisition error of biceps, 14.0 deg "
      "in pose low), 4 x not steady (worst: elbow not steady, 0.8 rad/s in pose low), 3 x not finite (worst: not "
      "finite in pose low)");
  EXPECT_EQ(stored, 0);
}

TEST(Calibration, EndsWithTheBestOfTheGenerationsBeforeOneThatIsAllInvalid) {
  int calls = 0;
  AnalyticEvaluator evaluator([&](const ArmModel&, std::size_t pose, PoseOutcome& outcome) {
    if (++calls > 3 * 24 && pose == 1) fail(outcome, PoseStatus::kNotSteady, 0, 1.0);
  });
  Calibration calibration(analyticArm(), poses(), analyticConfig(), evaluator);
  std::string third;
  calibration.run([&](const CalibrationState& state) {
    if (state.strategy.generation == 3) third = writeArm(calibration.bestModel());
  });
  const CalibrationState& state = calibration.state();
  EXPECT_EQ(state.strategy.generation, 4);
  EXPECT_EQ(state.strategy.stop, StopReason::kNoValidIndividual);
  EXPECT_EQ(state.history.back().invalid, 12);
  EXPECT_TRUE(std::isnan(state.history.back().best));
  EXPECT_EQ(writeArm(calibration.bestModel()), third);
  // What it left behind reads back, and the search has ended for it, too.
  Calibration resumed(analyticArm(), poses(), analyticConfig(), evaluator);
  resumed.restore(calibrationStateFromJson(Json::parse(toText(toJson(state)))));
  resumed.run([](const CalibrationState&) { ADD_FAILURE() << "nothing was left to do"; });
  EXPECT_EQ(writeArm(resumed.bestModel()), third);
}

TEST(CalibrationState, IsTheSameAfterAFileBitByBit) {
  AnalyticEvaluator evaluator;
  Calibration calibration(analyticArm(), poses(), analyticConfig(), evaluator);
  calibration.run([](const CalibrationState& state) {
    const std::string text = toText(toJson(state));
    const CalibrationState again = calibrationStateFromJson(Json::parse(text));
    EXPECT_EQ(toText(toJson(again)), text);
    EXPECT_EQ(again.strategy.best.y, state.strategy.best.y);
    EXPECT_EQ(again.strategy.best.s, state.strategy.best.s);
    EXPECT_EQ(again.strategy.best.fitness, state.strategy.best.fitness);
    ASSERT_EQ(again.strategy.parents.size(), state.strategy.parents.size());
    for (std::size_t i = 0; i < again.strategy.parents.size(); ++i) {
      EXPECT_EQ(again.strategy.parents[i].y, state.strategy.parents[i].y);
      EXPECT_EQ(again.strategy.parents[i].s, state.strategy.parents[i].s);
    }
    EXPECT_EQ(again.wall, state.wall);
    EXPECT_EQ(again.best_mje, state.best_mje);
  });
}

TEST(CalibrationState, KeepsNumbersThatAreHardToWrite) {
  CalibrationState state;
  state.strategy.parents = {{{-0.0, 5e-324, 1.7976931348623157e308, 0.1 + 0.2}, {1e-300, 1, 2, 3}, 1.0 / 3.0}};
  state.strategy.best.y = {1e23, -9007199254740993.0};
  const CalibrationState again = calibrationStateFromJson(Json::parse(toText(toJson(state))));
  EXPECT_EQ(again.strategy.parents[0].y, state.strategy.parents[0].y);
  EXPECT_TRUE(std::signbit(again.strategy.parents[0].y[0]));
  EXPECT_EQ(again.strategy.best.y, state.strategy.best.y);
  EXPECT_TRUE(std::isnan(again.strategy.best.fitness));
}

TEST(CalibrationState, KeepsADescentThatFoundNothingAndAFitnessThatIsNone) {
  CalibrationState state;
  GenerationRecord record;
  record.best = record.median = record.best_so_far = NAN;
  record.mje = {NAN, 0.5};
  state.history = {record};
  state.journal.whitened_at = Eigen::VectorXd::Constant(2, 0.1);
  state.journal.fits = {{Eigen::VectorXd::Constant(2, 0.3), INFINITY, 7, 11}};
  const CalibrationState again = calibrationStateFromJson(Json::parse(toText(toJson(state))));
  EXPECT_TRUE(std::isnan(again.history[0].best) && std::isnan(again.history[0].mje[0]));
  EXPECT_EQ(again.history[0].mje[1], 0.5);
  EXPECT_TRUE(std::isinf(again.journal.fits[0].objective));
  EXPECT_EQ(again.journal.fits[0].z, state.journal.fits[0].z);
  EXPECT_EQ(again.journal.fits[0].evaluations, 11);
}

TEST(CalibrationState, GoesOnBitIdenticallyFromEveryGeneration) {
  const auto spoil = [](const ArmModel& model, std::size_t pose, PoseOutcome& outcome) {
    if (pose == 0 && line(model, 1) > 0.22) fail(outcome, PoseStatus::kNotSteady, 0, 1.0);
  };
  AnalyticEvaluator evaluator(spoil);
  std::vector<std::string> files;
  Calibration whole(analyticArm(), poses(), analyticConfig(), evaluator);
  whole.run([&](const CalibrationState& state) { files.push_back(toText(toJson(state))); });
  ASSERT_EQ(files.size(), 8u);
  for (const std::string& file : files) {
    Calibration resumed(analyticArm(), poses(), analyticConfig(), evaluator);
    resumed.restore(calibrationStateFromJson(Json::parse(file)));
    resumed.run([](const CalibrationState&) {});
    EXPECT_EQ(textOf(resumed.state()), textOf(whole.state()));
    EXPECT_EQ(writeArm(resumed.bestModel()), writeArm(whole.bestModel()));
    EXPECT_GE(resumed.state().wall, calibrationStateFromJson(Json::parse(file)).wall);
  }
}

class EveryOptimiser : public testing::TestWithParam<const char*> {};

TEST_P(EveryOptimiser, GoesOnBitIdenticallyFromEveryStep) {
  const test::RecordedRig rig = test::recordRig(3);
  CalibrationConfig config = CalibrationConfig::read(YamlNode::load(test::sourceFile("configs/calibrate_arm.yaml")));
  config.optimizer = GetParam();
  config.evaluator = "equilibrium";
  config.starts = 4;
  config.strategy.mu = 2;
  config.strategy.lambda = 8;
  config.strategy.generations = 6;
  const auto evaluator = makeEquilibriumEvaluator(0);
  std::vector<std::string> files;
  Calibration whole(rig.model, rig.calibration, config, *evaluator);
  whole.run([&](const CalibrationState& state) { files.push_back(toText(toJson(state))); });
  ASSERT_EQ(files.size(), expectedSteps(config));
  for (const std::string& file : files) {
    Calibration resumed(rig.model, rig.calibration, config, *evaluator, /*threads=*/1);
    resumed.restore(calibrationStateFromJson(Json::parse(file)));
    resumed.run([](const CalibrationState&) {});
    EXPECT_EQ(textOf(resumed.state()), textOf(whole.state()));
    EXPECT_EQ(writeArm(resumed.bestModel()), writeArm(whole.bestModel()));
    EXPECT_GE(resumed.state().wall, calibrationStateFromJson(Json::parse(file)).wall);
  }
}
INSTANTIATE_TEST_SUITE_P(All, EveryOptimiser, testing::Values("es", "cma-es", "lm", "hybrid"));

TEST(CalibrationState, OfAnotherCalibrationIsRefused) {
  AnalyticEvaluator evaluator;
  Calibration calibration(analyticArm(), poses(), analyticConfig(), evaluator);
  calibration.run([](const CalibrationState&) {});
  const CalibrationState good = calibration.state();
  const auto errorWith = [&](const std::function<void(CalibrationState&)>& change) {
    CalibrationState state = good;
    change(state);
    return test::errorOf([&] { calibration.restore(state); });
  };
  EXPECT_EQ(errorWith([](CalibrationState&) {}), "no error");
  EXPECT_THAT(errorWith([](CalibrationState& s) { s.strategy.best.y.pop_back(); }), HasSubstr("2: the stored state"));
  EXPECT_THAT(errorWith([](CalibrationState& s) { s.strategy.parents[1].s.pop_back(); }),
              HasSubstr("2: stored strategy"));
  EXPECT_THAT(errorWith([](CalibrationState& s) { s.strategy.parents.clear(); }), HasSubstr("2: stored strategy"));
  EXPECT_THAT(errorWith([](CalibrationState& s) { s.best_mje.clear(); }), HasSubstr("2: the stored state"));
  EXPECT_THAT(errorWith([](CalibrationState& s) { s.history[2].mje.push_back(1); }), HasSubstr("2: the stored state"));
  for (const char* text : {"{}", "[]", "3", R"({"generation": "x"})"}) {
    EXPECT_THAT(test::errorOf([&] { calibrationStateFromJson(Json::parse(text)); }),
                HasSubstr("2: the stored state is not a simgap/calibration-state/1"))
        << text;
  }
}

}  // namespace
}  // namespace simgap
