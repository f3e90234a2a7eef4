// Poses after a change judge the models of a diagnosis, with nothing refitted. The arms are another program's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "intervene/poses/judged_rig.h"
#include "simgap/intervene/poses/pose_intervention.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kPayloadFirst = {"payload:link2", "passive-joint-torque:joint2", "gravity-tilt", "none"};
constexpr const char* kPayloadOff = "  - {kind: undo, cause: 'payload:link2'}\n";

reality::PoseDrawOptions payload() { return {.poses = 40, .fresh = 12, .effect = "payload"}; }

TEST(PoseIntervention, ConfirmsTheCauseThatWasTakenAway) {
  reality::PoseDrawOptions options = payload();
  options.cured = true;
  const Intervention result = Judged(seedOfAForearm(), options, kPayloadFirst).judge(kPayloadOff);
  EXPECT_EQ(result.verdict, InterventionVerdict::kConfirmed) << result.sentence;
  EXPECT_GT(result.predictions[0].p, 0.01);
  EXPECT_LT(result.predictions[1].log_odds, -3.0);
}

// A turn has several components: none of them may stay when it is taken away.
TEST(PoseIntervention, ATurnIsTakenAwayWhole) {
  reality::PoseDrawOptions options{.poses = 40, .fresh = 12, .effect = "gravity-tilt"};
  options.cured = true;
  const Judged judged(3, options, {"gravity-tilt", "marker-frame-offset:torso", "none"});
  const Intervention result = judged.judge("  - {kind: undo, cause: gravity-tilt}\n");
  EXPECT_EQ(result.verdict, InterventionVerdict::kConfirmed) << result.sentence;
}

TEST(PoseIntervention, TheSentenceSaysHowNearTheNamedModelCame) {
  const auto judgement = [](double p, double others) {
    const CandidateAnswer answers[] = {{"payload:hand", p, 0.0, false}, {"none", 0.0, others, true}};
    return judgeCandidates(answers, "poses");
  };
  EXPECT_EQ(judgement(0.3, -40.0).verdict, InterventionVerdict::kConfirmed);
  EXPECT_THAT(judgement(0.3, -40.0).sentence, HasSubstr("(odds beyond 1e+09 to 1)"));
  EXPECT_THAT(judgement(0.3, -4.0).sentence, HasSubstr("(odds 54.6 to 1)"));
  EXPECT_EQ(judgement(0.004, -40.0).verdict, InterventionVerdict::kCannotTell);
  EXPECT_THAT(judgement(0.004, -40.0).sentence, HasSubstr("not near enough (p 0.004)"));
  EXPECT_THAT(judgement(0.3, -1.0).sentence, HasSubstr("all predict much the same"));
  EXPECT_THAT(judgement(1e-5, -40.0).sentence, HasSubstr("none of 2 models"));
  const CandidateAnswer beside[] = {{"payload:hand", 1e-5, 0.0, false},
                                    {"payload:hand, gravity-tilt", 0.3, 2.0, false}};
  EXPECT_EQ(judgeCandidates(beside, "poses").verdict, InterventionVerdict::kCannotTell) << "it holds the payload, too";
  const CandidateAnswer unasked[] = {{"payload:hand", 0.04, 0.0, false},
                                     {"none", 0.0, -40.0, true},
                                     {"payload:hand, gravity-tilt", 0.3, 4.0, false, -6.0}};
  EXPECT_EQ(judgeCandidates(unasked, "poses").verdict, InterventionVerdict::kConfirmed) << "no tilt was there before";
  const CandidateAnswer more[] = {{"payload:hand", 0.56, 0.0, false},
                                  {"none", 0.0, -193.0, true},
                                  {"payload:hand, gravity-tilt", 0.96, 9.5, false, -1.0}};
  EXPECT_EQ(judgeCandidates(more, "poses").verdict, InterventionVerdict::kConfirmed) << "either way it is there";
}

TEST(PoseIntervention, WhatIsNeededByNoModelIsRefuted) {
  // With the slip of next to no size beside it the creep predicts the same: that keeps no slip.
  const auto judgement = [](double creep_before) {
    const CandidateAnswer answers[] = {{"potentiometer-slip:m", 1e-16, 0.0, false},
                                       {"cord-creep:m", 0.2, 107.3, true, creep_before},
                                       {"cord-creep:m, potentiometer-slip:m", 0.26, 109.1, false, 30.0}};
    return judgeCandidates(answers, "poses");
  };
  EXPECT_EQ(judgement(30.5).verdict, InterventionVerdict::kRefuted);
  EXPECT_THAT(judgement(30.5).sentence, HasSubstr("cord-creep:m predicts these poses, potentiometer-slip:m does not"));
  EXPECT_EQ(judgement(10.0).verdict, InterventionVerdict::kCannotTell) << "the poses before ask for both";
}

// A drive without a fault: 1.3 % smaller errors on thousands of rows once made "refuted" of a model that was right.
TEST(PoseIntervention, WhatTheDiagnosisRefusedRefutesNoModelThatPredicts) {
  const auto judgement = [](double p, bool refused) {
    const CandidateAnswer answers[] = {{"none", p, 0.0, false},
                                       {"backdrive-asymmetry", 0.26, 48.2, true, 80.1, refused}};
    return judgeCandidates(answers, "rows");
  };
  EXPECT_EQ(judgement(0.35, true).verdict, InterventionVerdict::kCannotTell);
  EXPECT_THAT(judgement(0.35, true).sentence, HasSubstr("but none predicts them, too"));
  EXPECT_EQ(judgement(1e-5, true).verdict, InterventionVerdict::kRefuted) << "what came after is new to the diagnosis";
  EXPECT_EQ(judgement(0.35, false).verdict, InterventionVerdict::kRefuted);
  EXPECT_THAT(judgement(0.35, false).sentence, HasSubstr("backdrive-asymmetry predicts these rows better than none"));
}

// A cause taken away, and the friction changed besides: the model without causes expects large errors, and is wrong,
// too.
TEST(PoseIntervention, NoModelIsRefutedByOneThatDoesNotPredictEither) {
  const CandidateAnswer answers[] = {{"bend-friction", 1e-9, 0.0, false}, {"none", 0.0037, 280.4, true, -8000.0}};
  const Judgement judgement = judgeCandidates(answers, "rows");
  EXPECT_EQ(judgement.verdict, InterventionVerdict::kCannotTell);
  EXPECT_THAT(judgement.sentence, HasSubstr("not near enough (p 0.0037)"));
}

// The edit test: the model that holds the payload survives its removal as well as one that never knew any.
TEST(PoseIntervention, APayloadsModelSurvivesItsRemoval) {
  reality::PoseDrawOptions with = payload(), without = payload();
  with.cured = true;
  without.causes = 0;
  without.effect.clear();
  const Judged told(seedOfAForearm(), without, {"none"});
  const double truth =
      told.judge("  - {kind: mass, body: link2, at_m: [0, 0, 0], mass_kg: 1.0e-6}\n").predictions[0].rms;
  const Intervention edited = Judged(seedOfAForearm(), with, kPayloadFirst).judge(kPayloadOff);
  EXPECT_LT(edited.predictions[0].rms, 1.3 * truth);
  EXPECT_GT(edited.predictions[3].rms, 1.3 * truth) << "without a payload to take off";
}

TEST(PoseIntervention, RefutesALookAlikeWhoseRemovalChangedNothing) {
  reality::PoseDrawOptions options = payload();
  options.change = [](reality::Arm&) {};
  const Judged judged(seedOfAForearm(), options, {"gravity-tilt", "payload:link2", "passive-joint-torque:joint2"});
  const Intervention result = judged.judge("  - {kind: undo, cause: gravity-tilt}\n");
  EXPECT_EQ(result.verdict, InterventionVerdict::kRefuted) << result.sentence;
  // A payload and a torque in the elbow say next to the same of these poses; neither is named alone then.
  EXPECT_THAT(result.sentence, testing::ContainsRegex("payload:link2.* predicts these poses better than gravity-tilt"));
}

TEST(PoseIntervention, PredictsAWeightThatWasHungOn) {
  reality::PoseDrawOptions options = payload();
  options.change = [](reality::Arm& arm) {
    reality::Part weight;
    weight.mass = 0.3;
    weight.position = {0.0, 0.0, -0.2};
    arm.links[1].parts.push_back(weight);
  };
  const Judged judged(seedOfAForearm(), options, kPayloadFirst);
  const Intervention told = judged.judge("  - {kind: mass, body: link2, at_m: [0, 0, -0.2], mass_kg: 0.3}\n");
  EXPECT_GT(told.predictions[0].p, 0.01) << told.sentence;
  const Intervention untold = judged.judge("  - {kind: mass, body: link2, at_m: [0, 0, -0.2], mass_kg: 0.001}\n");
  EXPECT_LT(untold.predictions[0].p, 1e-3);  // below it a model is refuted
  EXPECT_EQ(untold.verdict, InterventionVerdict::kCannotTell);
  EXPECT_THAT(untold.sentence, HasSubstr("none of 4 models predicts"));
  // How well the weight is known decides how much a wrong one counts.
  const Intervention vague =
      judged.judge("  - {kind: mass, body: link2, at_m: [0, 0, -0.2], mass_kg: 0.1, mass_sd_kg: 0.2}\n");
  EXPECT_GT(vague.predictions[0].p, 100.0 * untold.predictions[0].p);
}

TEST(PoseIntervention, CannotTellFromOnePoseOfASmallCause) {
  reality::PoseDrawOptions options{.poses = 40, .fresh = 1, .weak = true, .effect = "cord-hardening"};
  options.change = [](reality::Arm&) {};
  const Judged judged(3, options, {"cord-hardening", "spindle-coiling", "none"});
  const Intervention result = judged.judge("  - {kind: mass, body: link2, at_m: [0, 0, 0], mass_kg: 1.0e-6}\n");
  EXPECT_EQ(result.verdict, InterventionVerdict::kCannotTell) << result.sentence;
}

TEST(PoseIntervention, ForeseesWhatTellsModelsApart) {
  const Judged judged(seedOfAForearm(), payload(), kPayloadFirst);
  const ForeseenChange off = foreseeChange(judged.evidence, judged.changeOf(kPayloadOff));
  const ForeseenChange nothing = foreseeChange(
      judged.evidence, judged.changeOf("  - {kind: mass, body: link2, at_m: [0, 0, 0], mass_kg: 1.0e-6}\n"));
  EXPECT_GT(off.smallest, 2.0 * nothing.smallest);
  EXPECT_EQ(off.log_odds[0][0], 0.0);
  EXPECT_GT(off.largest_shift[3], 1.0);
}

TEST(PoseIntervention, RefusesWhatNoModelHolds) {
  const Judged judged(seedOfAForearm(), payload(), {"payload:link2", "none"});
  const auto sentence = [&](const char* yaml) { return errorOf([&] { judged.judge(yaml); }); };
  EXPECT_THAT(sentence("  - {kind: undo, cause: gravity-tilt}\n"),
              HasSubstr("2: found 'gravity-tilt' to undo, which no model of the diagnosis holds; expected one of "
                        "payload:link2"));
  EXPECT_THAT(sentence("  - {kind: undo, cause: 'payload:link2'}\n  - {kind: undo, cause: gravity-tilt}\n"),
              HasSubstr("found 'gravity-tilt' to undo"));
  EXPECT_THAT(sentence("  - {kind: undo, cause: 'payload:nobody'}\n"), HasSubstr("found 'payload:nobody', expected"));
  EXPECT_THAT(sentence("  - {kind: undo, cause: rust}\n"), HasSubstr("found 'rust', expected a cause"));
  EXPECT_THAT(sentence("  - {kind: mass, body: link2, at_m: [0, 0, 0], mass_kg: -50}\n"),
              HasSubstr("the change takes 50 kg off body link2"));
  EXPECT_THAT(sentence("  - {kind: paint, body: link2}\n"), HasSubstr("paint"));
}

}  // namespace
}  // namespace simgap::test
