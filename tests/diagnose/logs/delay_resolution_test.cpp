// How long a channel is late is known no better than rows tell it: intervals that said more missed two times of three.
#include <gtest/gtest.h>

#include <cmath>

#include "diagnose/logs/held_out.h"
#include "diagnose/logs/log_causes.h"
#include "prepared_logs.h"
#include "reality/servo_draws.h"

namespace simgap::test {
namespace {

using reality::benchYaml;
using reality::drawServoNone;
using reality::Mechanism;
using reality::recordServo;
using reality::ServoDraw;

/// A controlled drive with an encoder, whose effort is logged some rows late.
class LateServo : public testing::TestWithParam<Mechanism> {
 protected:
  static constexpr int kLate = 2;

  static PreparedLog log(std::uint64_t seed) {
    ServoDraw draw = drawServoNone(seed, GetParam());
    draw.rig.rows = 5000;
    draw.secret.delay = kLate / draw.rig.rate;
    const std::string bench = benchYaml(draw.rig);
    return prepareLog(CsvTable::parse(recordServo(draw.rig, draw.secret).csv(), "log.csv"),
                      readBench(YamlNode::parse(bench, "rig.yaml")), ActuatorKind::kFriction);
  }
};

TEST_P(LateServo, IsLateByAnIntervalThatHoldsTheTruth) {
  for (const std::uint64_t seed : {5101u, 5102u, 5103u}) {
    const PreparedLog log = LateServo::log(seed);
    const LogDiagnosisOptions options;
    const LogSearch search(friction::find("stribeck"), log.data, splitLog(log, options).training, options);
    Fitted rest = search.fit({}, nullptr);
    search.validate(rest);
    Fitted late = search.tryAll(rest, {{&actuator_effects::find("channel-delay"), {}, {}}})[0].fitted;
    const LogFit fit = describe(search, log, late);
    const Estimate& dt = fit.parameters[late.model->firstParameter(0)];
    const double half = fit.t * dt.sd, step = log.data.rows.step;
    EXPECT_NEAR(dt.value, kLate * step, half) << seed;
    EXPECT_LT(half, step) << seed;  // nor does it say nothing
    // What the rows alone say of it is less than what is said.
    const Eigen::MatrixXd rows_alone = search.refit(late, log.blocks);
    const auto i = static_cast<Eigen::Index>(late.model->firstParameter(0));
    EXPECT_NEAR(dt.sd, std::hypot(std::sqrt(rows_alone(i, i)), step / std::sqrt(12.0)), 0.02 * dt.sd) << seed;
  }
}

// A late row counts where the motion that it answers to does; a clipped effort is clipped where it was logged.
TEST(DelayedRows, CountWhereTheirMotionDoesAndTheirEffortIsThere) {
  PreparedLog log = preparedLog(smallRig());
  log.data.effort_lost.assign(log.data.keep.size(), false);
  log.data.effort_lost[500] = true;
  log.data.keep[500] = false;
  const ActuatorRegression model(friction::find("classic"), {&actuator_effects::find("channel-delay")}, log.data, {});
  std::vector<double> theta(model.parameters().size(), 0.01);
  theta[model.firstParameter(0)] = 1.4 * log.data.rows.step;
  Eigen::VectorXd residual;
  model.evaluate(model.solveCoefficients(theta, log.blocks), residual, nullptr);
  for (std::size_t i = 2; i < log.data.keep.size(); ++i) {
    if (log.data.rows.session[i] != log.data.rows.session[i - 1]) continue;
    const bool counts = log.data.keep[i - 1] && !log.data.effort_lost[i];
    ASSERT_EQ(residual[i] != 0.0, counts) << "row " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Mechanisms, LateServo, testing::Values(Mechanism::kPendulum, Mechanism::kVoltageServo));

}  // namespace
}  // namespace simgap::test
