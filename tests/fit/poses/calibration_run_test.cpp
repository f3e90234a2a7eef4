#include "simgap/fit/poses/calibration_run.h"

#include <gtest/gtest.h>

#include "simgap/model/arm/arm_yaml.h"
#include "support/analytic_evaluator.h"
#include "support/files.h"

namespace simgap {
namespace {

using test::AnalyticEvaluator;

TEST(CalibrationRun, CountsTheStepsOfEveryOptimiser) {
  CalibrationConfig config = test::analyticConfig();
  EXPECT_EQ(expectedSteps(config), std::size_t(config.strategy.generations));
  config.optimizer = "lm";
  config.starts = 5;
  EXPECT_EQ(expectedSteps(config), 5u);
  config.optimizer = "hybrid";
  EXPECT_GT(expectedSteps(config), 5u) << "what the strategy finds is polished, too";
}

TEST(CalibrationRun, WhatIsStoredIsGoneOnWith) {
  const test::TemporaryFolder folder;
  const RunDirectory directory = RunDirectory::create(folder.path() / "run", /*force=*/false);
  const std::vector<Pose> poses = test::analyticPoses();
  AnalyticEvaluator evaluator;
  CalibrationConfig config = test::analyticConfig();
  Calibration straight(test::analyticArm(), poses, config, evaluator);
  EXPECT_FALSE(restoreStored(straight, directory)) << "nothing is stored yet";
  straight.run([](const CalibrationState&) {});

  CalibrationConfig half = config;
  half.strategy.generations /= 2;
  Calibration first(test::analyticArm(), poses, half, evaluator);
  int steps = 0;
  searchAndStore(first, directory, [&](const CalibrationState&) { ++steps; });
  EXPECT_EQ(steps, half.strategy.generations);
  Calibration second(test::analyticArm(), poses, config, evaluator);
  ASSERT_TRUE(restoreStored(second, directory));
  second.run([](const CalibrationState&) {});
  EXPECT_EQ(second.state().strategy.generation, config.strategy.generations);
  EXPECT_EQ(writeArm(second.bestModel()), writeArm(straight.bestModel()));
}

TEST(CalibrationRun, RefusesAStateThatIsNone) {
  const test::TemporaryFolder folder;
  const RunDirectory directory = RunDirectory::create(folder.path() / "run", /*force=*/false);
  directory.write("state.json", std::string_view("{}"));
  AnalyticEvaluator evaluator;
  const std::vector<Pose> poses = test::analyticPoses();
  Calibration calibration(test::analyticArm(), poses, test::analyticConfig(), evaluator);
  EXPECT_NE(test::errorOf([&] { restoreStored(calibration, directory); }), "");
}

}  // namespace
}  // namespace simgap
