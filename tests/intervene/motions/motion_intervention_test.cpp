// A cause found in motions, and a change of the arm that it has to survive: recorded by the independent simulator.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "diagnose/motions/motion_cases.h"
#include "simgap/core/error.h"
#include "simgap/intervene/motions/motion_intervention.h"

namespace simgap {
namespace {

using test::MotionCase;

void noNews(double) {}

constexpr std::uint64_t kAfter = 700;  // the first motion after a change, of a forearm's thousand
constexpr std::size_t kMotionsAfter = 3;

/// What a diagnosis leaves for an intervention.
MotionEvidence evidenceOf(const MotionCase& one) {
  MotionEvidence evidence{one.model, test::motionConfig(), one.said.candidates, one.said.reference, one.said.noise, {}};
  for (const RecordedMotion& motion : one.said.profile) {
    evidence.profile.push_back({motion.name, motion.commands});
  }
  return evidence;
}

ArmChanges armChanges(const std::string& list, const ArmModel& model) {
  return ArmChanges::read(YamlNode::parse("format: simgap/change/1\nchanges: [" + list + "]\n", "change.yaml"), model);
}

/// Motions of the same forearm without what was hidden in it.
MotionSet curedMotions(const MotionCase& one, std::uint64_t seed) {
  const test::HiddenMotionCase cured = test::drawHidden(test::MotionArm::kForearm, seed, *test::findMotionTruth(""));
  return test::recordForearm(cured, one.model, 1000 * seed + kAfter, kMotionsAfter);
}

MotionSet unchangedMotions(const MotionCase& one, std::uint64_t seed) {
  return test::recordForearm(one.hidden, one.model, 1000 * seed + kAfter, kMotionsAfter);
}

/// What a model is off by [noise sd].
double rmsOf(const PlayedCandidate& prediction) { return std::sqrt(prediction.squares.mean()); }

/// A payload of 0.26 kg, found: what is asked of it takes less time than to find it.
class MotionIntervention : public testing::Test {
 protected:
  void aPayloadSurvivesItsRemovalAndItsLookAlikesDoNot() const {
    ASSERT_EQ(evidence_.candidates.front().causes, "payload:link1");
    const simgap::MotionIntervention judged = judgeChange(evidence_, off_, after_, noNews);
    EXPECT_EQ(judged.verdict, InterventionVerdict::kConfirmed) << judged.sentence;
    // The edit test: a model that was told of no payload, fitted to as many motions without it, misses by hardly less.
    const MotionCase told = test::diagnoseForearmWith(*test::findMotionTruth(""), kSeed);
    const auto best = judgeChange(evidenceOf(told), {}, after_, noNews);
    std::printf("after the payload was taken off: %.3f sd, a model that was told the truth %.3f sd\n",
                rmsOf(judged.predictions.front()), rmsOf(best.predictions.front()));
    EXPECT_LT(rmsOf(judged.predictions.front()), 1.3 * rmsOf(best.predictions.front()));
  }

  void anotherCauseInItsPlaceIsRefuted() const {
    MotionEvidence evidence = evidence_;
    ASSERT_GE(evidence.candidates.size(), 3u);
    std::swap(evidence.candidates[0], evidence.candidates[1]);
    const std::string other = evidence.candidates.front().causes;
    const simgap::MotionIntervention judged = judgeChange(evidence, off_, after_, noNews);
    EXPECT_EQ(judged.verdict, InterventionVerdict::kRefuted) << other << ": " << judged.sentence;
    EXPECT_THAT(judged.sentence, testing::StartsWith("payload:link1 predicts these motions"));
  }

  void aChangeThatWasNotMadeConfirmsNothing() const {
    const ArmChanges hung =
        armChanges("{kind: mass, body: link1, at_m: [0, 0, -0.2], mass_kg: 0.3, mass_sd_kg: 0.005}", evidence_.given);
    const simgap::MotionIntervention judged = judgeChange(evidence_, hung, unchangedMotions(payload_, kSeed), noNews);
    EXPECT_NE(judged.verdict, InterventionVerdict::kConfirmed) << judged.sentence;
  }

  void itIsForeseenWhatTellsTheSameEachTime() const {
    const auto foresee = [&] { return foreseeChange(evidence_, off_, evidence_.profile, noNews); };
    const ForeseenChange taken_off = foresee(), again = foresee();
    EXPECT_EQ(taken_off.log_odds, again.log_odds);
    EXPECT_GT(taken_off.smallest, kDecisiveLogOdds);
    EXPECT_EQ(taken_off.largest_shift.front(), 0.0);
    for (std::size_t c = 1; c < evidence_.candidates.size(); ++c) EXPECT_GT(taken_off.largest_shift[c], 0.0);
  }

  void whatNoModelHoldsCannotBeUndone() const {
    const ArmChanges off = armChanges("{kind: undo, cause: supply-sag}", evidence_.given);
    EXPECT_THROW(judgeChange(evidence_, off, unchangedMotions(payload_, kSeed), noNews), ConfigError);
    MotionEvidence cut = evidence_;
    cut.candidates.front().covariance.conservativeResize(3, 3);
    EXPECT_THROW(cut.validate(), ConfigError);
  }

  static constexpr std::uint64_t kSeed = 201;
  const MotionCase payload_ = test::diagnoseForearmWith(*test::findMotionTruth("payload"), kSeed);
  const MotionEvidence evidence_ = evidenceOf(payload_);
  const ArmChanges off_ = armChanges("{kind: undo, cause: 'payload:link1'}", evidence_.given);
  const MotionSet after_ = curedMotions(payload_, kSeed);
};

TEST_F(MotionIntervention, OfAPayloadThatWasFound) {
  aPayloadSurvivesItsRemovalAndItsLookAlikesDoNot();
  anotherCauseInItsPlaceIsRefuted();
  aChangeThatWasNotMadeConfirmsNothing();
  itIsForeseenWhatTellsTheSameEachTime();
  whatNoModelHoldsCannotBeUndone();
}

TEST(ArmChangeOfSupply, IsOfAllMotorsOrOfOne) {
  const ArmModel given = test::modelOf(test::movingForearm().arm, true);
  ArmModel all = given, one = given;
  armChanges("{kind: supply, voltage_V: 9}", given).apply(all);
  armChanges("{kind: supply, muscle: muscle2, voltage_V: 9}", given).apply(one);
  EXPECT_EQ(all.muscles[0].motor.supply_voltage, 9.0);
  EXPECT_EQ(all.muscles[1].motor.supply_voltage, 9.0);
  EXPECT_EQ(one.muscles[0].motor.supply_voltage, given.muscles[0].motor.supply_voltage);
  EXPECT_EQ(one.muscles[1].motor.supply_voltage, 9.0);
  EXPECT_THROW(armChanges("{kind: supply, voltage_V: 0}", given), ConfigError);
  EXPECT_THROW(armChanges("{kind: supply, muscle: soleus, voltage_V: 9}", given), ConfigError);
}

/// Causes hidden in forearms, found, and taken away; and the next best, believed and taken away although it was never
/// there. The table of docs/studies/interventions.md.
TEST(SlowMotionInterventionStudy, TheTrueCauseIsConfirmedAndLookAlikesRefuted) {
  constexpr std::uint64_t kFirst = 341, kLast = 346;  // the rules were made on 301 to 336
  int named = 0, confirmed = 0, alike = 0, refuted = 0, falsely = 0, telling = 0, told = 0;
  for (std::uint64_t seed = kFirst; seed <= kLast; ++seed) {
    for (const test::MotionTruth& truth : test::motionTruths()) {
      const std::string effect = truth.effect;
      if (effect.empty() || findArmEffect(effect) == nullptr) continue;  // an ordinary parameter: nothing to undo
      const MotionCase one = test::diagnoseForearmWith(truth, seed);
      if (one.said.candidates.size() < 2) continue;
      MotionEvidence evidence = evidenceOf(one);
      const std::string& target = one.hidden.target;
      const std::string label = target.empty() ? effect : effect + ":" + target;
      const auto undo = [&](const std::string& cause) {
        return armChanges("{kind: undo, cause: '" + cause + "'}", evidence.given);
      };
      if (evidence.candidates[0].causes == label) {
        ++named;
        const auto result = judgeChange(evidence, undo(label), curedMotions(one, seed), noNews);
        confirmed += result.verdict == InterventionVerdict::kConfirmed ? 1 : 0;
        const PlayedCandidate& own = result.predictions.front();
        std::printf("  %lu %s taken away: %s, %.2f sd, %.2f left (p %.2g), way p %.2g\n",
                    static_cast<unsigned long>(seed), label.c_str(), toString(result.verdict).data(), rmsOf(own),
                    own.left, own.p_left, own.p_way);
      }
      for (std::size_t c = 1; c < evidence.candidates.size(); ++c) {
        const std::string other = evidence.candidates[c].causes;
        if (other == label || other.find(',') != std::string::npos || other == "none") continue;
        std::swap(evidence.candidates[0], evidence.candidates[c]);
        const auto result = judgeChange(evidence, undo(other), unchangedMotions(one, seed), noNews);
        const ForeseenChange foreseen = foreseeChange(evidence, undo(other), evidence.profile, noNews);
        const bool right = result.verdict == InterventionVerdict::kRefuted;
        const bool tells = foreseen.log_odds[c][0] > kDecisiveLogOdds;
        ++alike;
        refuted += right ? 1 : 0;
        falsely += result.verdict == InterventionVerdict::kConfirmed ? 1 : 0;
        telling += tells ? 1 : 0;
        told += right && tells ? 1 : 0;
        std::printf("  %lu %s, %s taken away: %s (foreseen ln odds %.1f)\n", static_cast<unsigned long>(seed),
                    label.c_str(), other.c_str(), result.sentence.c_str(), foreseen.log_odds[c][0]);
        break;
      }
      std::fflush(stdout);
    }
  }
  std::printf(
      "confirmed %d of %d, look-alikes refuted %d of %d (of those foreseen to be told apart %d of %d), falsely "
      "confirmed %d\n",
      confirmed, named, refuted, alike, told, telling, falsely);
  ASSERT_GE(named + alike, 60);
  EXPECT_GE(confirmed, 0.9 * named);
  EXPECT_LE(falsely, 0.05 * alike);
  EXPECT_GE(refuted, 0.9 * alike);
}

}  // namespace
}  // namespace simgap
