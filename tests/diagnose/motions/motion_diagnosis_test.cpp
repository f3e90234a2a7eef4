// Diagnoses of motions that the independent simulator recorded, with nothing hidden and with one cause hidden.
#include "simgap/diagnose/motions/motion_diagnosis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnose/motions/motion_cases.h"
#include "diagnose/motions/motion_hypotheses.h"

namespace simgap {
namespace {

reality::Setpoints variedSetpoints(std::uint64_t draw) { return test::opposedSwings(draw, {0.2, 0.7, 0.3, 0.8, 95}); }

MotionDiagnosis diagnoseForearm(const reality::MovingArm& truth, reality::MotionRigOptions rig = {},
                                const std::vector<std::string>& effects = {}) {
  const ArmModel model = test::modelOf(test::movingForearm().arm, true);
  const MotionSet selecting = test::recordMotions(truth, model, variedSetpoints, 0, 5, rig),
                  judging = test::recordMotions(truth, model, variedSetpoints, 100, 5, rig);
  MotionDiagnosisOptions options;
  options.effects = effects;
  return diagnoseMotions(model, selecting, &judging,
                         MotionCalibrationConfig::read(YamlNode::parse(test::forearmConfig(), "forearm_config.yaml")),
                         options, [](const std::string&, double) {});
}

std::string answerOf(const MotionDiagnosis& result) {
  std::string text(toString(result.diagnosis.verdict));
  for (const Cause& cause : result.diagnosis.causes) {
    text += "; " + cause.effect + ":" + cause.target;
    for (const std::string& rival : cause.ambiguous_with) text += " | " + rival;
    for (const Estimate& p : cause.parameters) text += " " + p.name + "=" + std::to_string(p.value);
  }
  for (const HypothesisRecord& h : result.diagnosis.hypotheses) {
    text += "\n  " + h.effect + ":" + h.target + " " + h.outcome + " " + std::to_string(h.log_odds.value_or(NAN));
  }
  text += "\n  heldout " + std::to_string(result.diagnosis.baseline.mse_heldout) + " -> " +
          std::to_string(result.diagnosis.extended.mse_heldout);
  for (const Candidate& candidate : result.diagnosis.candidates) {
    text += "; candidate " + candidate.effect + ":" + candidate.target + " " + candidate.reason;
  }
  return text;
}

/// The first cause is this one, or one of those that could not be told from it. \returns its first parameter
double expectFound(const MotionDiagnosis& result, const std::string& effect) {
  if (result.diagnosis.causes.empty()) {
    ADD_FAILURE() << "nothing found: " << answerOf(result);
    return NAN;
  }
  const Cause& first = result.diagnosis.causes.front();
  EXPECT_EQ(first.effect, effect) << answerOf(result);
  EXPECT_GT(first.gain_heldout.lower95, 0.0);
  EXPECT_LE(result.diagnosis.causes.size(), 1u) << answerOf(result);
  return first.parameters.front().value;
}

TEST(MotionDiagnosis, WhereNothingIsHiddenNothingIsNamed) {
  const MotionDiagnosis result = diagnoseForearm(test::trueForearm());
  EXPECT_EQ(result.diagnosis.verdict, DiagnosisVerdict::kNothingFound) << answerOf(result);
  EXPECT_TRUE(result.diagnosis.causes.empty());
  EXPECT_LT(result.diagnosis.baseline.mse_heldout, 1.5);
}

TEST(MotionDiagnosis, FindsTheClockOfTheCapture) {
  reality::MotionRigOptions rig;
  rig.capture_delay = 0.05;
  EXPECT_NEAR(expectFound(diagnoseForearm(test::trueForearm(), rig), "joint-clock-offset"), 0.05, 0.003);
}

TEST(MotionDiagnosis, FindsLateCommands) {
  reality::MovingArm truth = test::trueForearm();
  truth.hidden.command_delay = 0.04;
  const MotionDiagnosis result = diagnoseForearm(truth);
  EXPECT_NEAR(expectFound(result, "command-latency"), 0.04, 0.002);
  ASSERT_FALSE(result.diagnosis.causes.empty());
  const Estimate& delay = result.diagnosis.causes.front().parameters.front();
  EXPECT_LE(delay.upper95 - delay.value, 0.012);  // a row of the commands is 10 ms
  EXPECT_GE(delay.upper95 - delay.value, 0.010);
}

TEST(MotionDiagnosis, SharesOfWhatIsLeftAddUp) {
  reality::MovingArm truth = test::trueForearm();
  truth.hidden.command_delay = 0.04;
  const Diagnosis d = diagnoseForearm(truth, {}, {"gear-backlash"}).diagnosis;
  ASSERT_EQ(d.verdict, DiagnosisVerdict::kUnexplained) << d.sentence;
  double sum = 0.0;
  for (const Leftover& left : d.unexplained) sum += left.share;
  EXPECT_GT(sum, 0.3);
  EXPECT_NEAR(sum, 0.01 * d.left_over_percent, 1e-9);
  EXPECT_LE(d.left_over_percent, 100.0);
}

TEST(MotionDiagnosis, FindsAClockThatIsLittleMoreThanItsOwn) {
  reality::MotionRigOptions rig;
  rig.capture_delay = 0.022;
  EXPECT_NEAR(expectFound(diagnoseForearm(test::trueForearm(), rig), "joint-clock-offset"), 0.022, 0.001);
}

TEST(SlowMotionDiagnosis, GuidesOfAllCordsAreNotNamedAsThoseOfOne) {
  reality::MovingArm truth = test::trueForearm();
  truth.hidden.guide_loss = 0.13;
  const MotionDiagnosis result = diagnoseForearm(truth);
  EXPECT_NEAR(expectFound(result, "guide-friction"), 0.13, 0.015);
  ASSERT_FALSE(result.diagnosis.causes.empty());
  EXPECT_EQ(result.diagnosis.causes.front().target, "") << answerOf(result);
}

/// A forearm of the study with one cause hidden.
MotionDiagnosis diagnoseDrawnForearm(const char* effect, std::uint64_t seed) {
  return test::diagnoseForearmWith(*test::findMotionTruth(effect), seed).said;
}

// Where the fit without a cause comes to, a payload looks like more inertia: the scan does not promise it a fit.
TEST(SlowMotionDiagnosis, APayloadIsNotNamedAsInertia) {
  EXPECT_NEAR(expectFound(diagnoseDrawnForearm("payload", 202), "payload"), 0.213, 0.08);  // mass x distance is known
}

// There the fit without a cause is lost, and the scan likes six others better.
TEST(SlowMotionDiagnosis, LooksFurtherWhereTheBestLeavesMuch) {
  EXPECT_NEAR(expectFound(diagnoseDrawnForearm("controller-gain", 204), "controller-gain"), 0.5995, 0.01);
}

// A cord whose damping is beyond what a fit may carry is not one that relaxes within a moment.
TEST(SlowMotionDiagnosis, MuchMoreDampingIsNoRelaxation) {
  EXPECT_GT(expectFound(diagnoseDrawnForearm("cord-damping", 204), "cord-damping"), 4.0);
}

// A passive torque is accepted first, and stands for nothing once the guides are there.
TEST(MotionDiagnosis, WhatStoodForAnotherCauseIsTakenBack) {
  EXPECT_NEAR(expectFound(diagnoseDrawnForearm("guide-friction", 111), "guide-friction"), 0.2026, 0.02);
}

// The fit of all cords is lost where the scan begins it; it is found from where that of one cord stands.
TEST(SlowMotionDiagnosis, RelaxationOfAllCordsIsNotNamedAsThatOfOne) {
  const MotionDiagnosis result = diagnoseDrawnForearm("cord-relaxation", 115);
  EXPECT_NEAR(expectFound(result, "cord-relaxation"), 0.157, 0.02);
  ASSERT_FALSE(result.diagnosis.causes.empty());
  EXPECT_EQ(result.diagnosis.causes.front().target, "") << answerOf(result);
}

// The model is so lost without it that the scan promises placebos as much; held-out motions speak for it.
TEST(SlowMotionDiagnosis, WhatExplainsALostModelNeedsNoPlacebo) {
  const MotionDiagnosis result = diagnoseDrawnForearm("current-limit", 106);
  EXPECT_NEAR(expectFound(result, "current-limit"), 1.336, 0.05);
  ASSERT_FALSE(result.diagnosis.causes.empty());
  EXPECT_LT(result.diagnosis.causes.front().p_adjusted, 0.05);
}

TEST(SlowMotionDiagnosis, ALimitOfCurrentsIsKnownToAPartOfItself) {
  const MotionDiagnosis result = diagnoseDrawnForearm("current-limit", 203);
  expectFound(result, "current-limit");
  ASSERT_FALSE(result.diagnosis.causes.empty());
  const Estimate& limit = result.diagnosis.causes.front().parameters.front();
  EXPECT_LT(limit.lower95, 1.168);
  EXPECT_GT(limit.upper95, 1.168);
  EXPECT_LT(limit.upper95 - limit.lower95, 0.3);
}

// A muscle over one joint cannot bend round a second, whatever else is missing.
TEST(MotionDiagnosis, AsksATargetForChoicesThatItHasOnly) {
  const ArmModel model = test::modelOf(test::movingForearm().arm, true);
  std::vector<NotTestable> not_testable;
  const std::vector<ArmHypothesis> hypotheses = motionHypotheses(model, {"muscle-wrap"}, not_testable);
  ASSERT_EQ(hypotheses.size(), 2u);
  for (const ArmHypothesis& hypothesis : hypotheses) {
    EXPECT_EQ(hypothesis.starts.size(), 5u);
    for (const EffectParameters& start : hypothesis.starts) EXPECT_EQ(start[1], 1.0);
  }
  reality::MovingArm truth = test::trueForearm();
  truth.hidden.relaxing_share = 0.3;
  const MotionDiagnosis result = diagnoseForearm(truth, {}, {"muscle-wrap"});
  const auto fitted = [](const HypothesisRecord& h) { return h.log_odds && !h.outcome.ends_with("placebos"); };
  EXPECT_TRUE(std::ranges::any_of(result.diagnosis.hypotheses, fitted)) << answerOf(result);
}

TEST(MotionDiagnosis, AStuckShaftIsAFaultOfTheData) {
  const ArmModel model = test::modelOf(test::movingForearm().arm, true);
  MotionSet set = test::recordMotions(test::trueForearm(), model, variedSetpoints, 0, 8, {});
  std::vector<double>& shafts = set.motions[2].muscles[1].shafts;
  std::ranges::fill(shafts, shafts.front());
  const MotionCalibrationConfig config =
      MotionCalibrationConfig::read(YamlNode::parse(test::forearmConfig(), "forearm_config.yaml"));
  const MotionDiagnosis result = diagnoseMotions(model, set, nullptr, config, {}, [](const std::string&, double) {});
  EXPECT_EQ(result.diagnosis.verdict, DiagnosisVerdict::kDataFault);
  ASSERT_FALSE(result.diagnosis.faults.empty());
  EXPECT_EQ(result.diagnosis.faults.front().channel, "shaft_muscle2_rad");
  EXPECT_NE(result.diagnosis.faults.front().sentence.find("motion m2"), std::string::npos);
}

}  // namespace
}  // namespace simgap
