#include "diagnose/logs/log_hypotheses.h"

#include <gtest/gtest.h>

#include "diagnose/logs/held_out.h"
#include "prepared_logs.h"
#include "simgap/fit/actuators/actuator_model.h"

namespace simgap::test {
namespace {

TEST(LogHypotheses, ACauseIsFoundAgainWhereTheOthersHaveLeftTheirPlacesWithoutIt) {
  reality::DriveSecret secret;
  secret.current_bias = 0.5;
  secret.ripple = 1.0;
  secret.ripple_ratio = 9.0;
  const PreparedLog log = preparedLog(smallRig(6000), secret);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("classic"), log.data, splitLog(log, options).training, options);
  const Hypothesis ripple{&actuator_effects::find("position-ripple"), {}, {}};
  const Hypothesis bias{&actuator_effects::find("current-bias"), {}, {}};
  Fitted rest = search.tryAll(search.fit({}, nullptr), {ripple})[0].fitted;
  Fitted whole = search.tryAll(rest, {bias})[0].fitted;
  rest.theta[rest.model->firstParameter(0)] *= 1.5;  // its ratio: no descent leads back from there
  EXPECT_GT(search.tryAll(rest, {bias})[0].fitted.mse, 1.1 * whole.mse);
  EXPECT_LE(search.tryAll(rest, {bias}, &whole)[0].fitted.mse, (1.0 + 1e-6) * whole.mse);
}

// Between the rows a delay's error has a valley beside the lowest: a descent that began in it stayed there.
TEST(LogHypotheses, ADelayIsFoundInTheLowestOfItsValleys) {
  reality::DriveDraw draw = reality::drawNone(13);
  draw.rig.rows = 12000;
  draw.secret.delay = 0.05;  // 1.25 rows
  const PreparedLog log = preparedLog(draw.rig, draw.secret);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("classic"), log.data, splitLog(log, options).training, options);
  const ActuatorEffect* delay = &actuator_effects::find("channel-delay");
  const Trial trial = search.tryAll(search.fit({}, nullptr), {{delay, {}, {}}})[0];
  const std::size_t dt = trial.fitted.model->firstParameter(0);
  EXPECT_NEAR(trial.fitted.theta[dt], draw.secret.delay, 0.1 * search.step());
  for (double rows = -1.9; rows < 4.0; rows += 0.4) {
    Fitted other = trial.fitted;
    other.theta[dt] = rows * search.step();
    EXPECT_GT(search.fit({delay}, &other).mse, (1.0 - 5e-3) * trial.fitted.mse) << "from " << rows << " rows";
  }
}

TEST(LogHypotheses, WhatALongLogIsSearchedWithOnFewRowsIsFittedOnAll) {
  reality::DriveSecret secret;
  secret.current_bias = 0.5;
  const PreparedLog log = preparedLog(smallRig(20000), secret);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("classic"), log.data, splitLog(log, options).training, options);
  ASSERT_GT(rowsIn(search.training(), log.data.keep), 2.0 * LogSearch::kFewRows);
  const ActuatorEffect* bias = &actuator_effects::find("current-bias");
  const Fitted base = search.fit({}, nullptr);
  const Trial trial = search.tryAll(base, {{bias, {}, {}}})[0];
  EXPECT_LE(trial.fitted.mse, (1.0 + 1e-4) * search.fit({bias}, nullptr).mse);  // from every start, on all rows
  EXPECT_GT(trial.gain_training, 0.1);
  // What explains nothing is refused on the few.
  const Trial other = search.tryAll(trial.fitted, {{&actuator_effects::find("bend-friction"), {}, {}}})[0];
  EXPECT_LT(other.gain_training, 0.5 * options.least_gain);
  EXPECT_FALSE(other.gain.has_value());
}

}  // namespace
}  // namespace simgap::test
