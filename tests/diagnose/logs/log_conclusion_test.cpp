// What is said at the end where no cause was found.
#include "diagnose/logs/log_conclusion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace simgap {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Diagnosis withoutCauses(double rms, double noise) {
  Diagnosis d;
  d.baseline.mse_heldout = d.extended.mse_heldout = rms * rms;
  d.noise_floor = noise * noise;
  conclude(d);
  return d;
}

PreparedLog minutesOfLog(double minutes) {
  PreparedLog log;
  log.data.rows.time = log.data.rows.elapsed = Eigen::ArrayXd::LinSpaced(10, 0.0, 60.0 * minutes);
  return log;
}

TEST(LogConclusion, AtTheNoiseNothingIsMissing) {
  const Diagnosis d = withoutCauses(0.253, 0.251);
  EXPECT_EQ(d.verdict, DiagnosisVerdict::kNothingFound);
  EXPECT_THAT(d.sentence, HasSubstr("RMS 0.253, noise floor 0.251."));
  EXPECT_THAT(nextExperiment(d, minutesOfLog(2.0)), HasSubstr("Nothing is missing at this noise"));
}

TEST(LogConclusion, ANoiseThatIsNotKnownIsNotNone) {
  const Diagnosis d = withoutCauses(1.05, 0.0);
  EXPECT_THAT(d.sentence, HasSubstr("RMS 1.05, noise floor unknown."));
  const std::string next = nextExperiment(d, minutesOfLog(2.0));
  EXPECT_THAT(next, HasSubstr("do not tell their own noise"));
  EXPECT_THAT(next, Not(HasSubstr("Nothing is missing")));
}

// A push from outside that no sensor saw: found nothing, but not everything is well.
TEST(LogConclusion, FarAboveTheNoiseSomethingIsThatNoChannelShows) {
  const Diagnosis d = withoutCauses(0.16, 0.04);
  EXPECT_EQ(d.verdict, DiagnosisVerdict::kNothingFound);
  EXPECT_THAT(d.sentence, HasSubstr("no logged channel explains what is left"));
  const std::string next = nextExperiment(d, minutesOfLog(2.0));
  EXPECT_THAT(next, HasSubstr("4.0 times the noise"));
  EXPECT_THAT(next, Not(HasSubstr("Nothing is missing")));
}

TEST(LogConclusion, BetweenTheTwoItIsNotSaidThatNothingIsMissing) {
  const std::string next = nextExperiment(withoutCauses(0.0223, 0.0146), minutesOfLog(1.0));
  EXPECT_THAT(next, HasSubstr("1.5 times the noise"));
  EXPECT_THAT(next, Not(HasSubstr("Nothing is missing")));
}

TEST(LogConclusion, WhatToRecordCanBeDone) {
  Diagnosis d;
  d.verdict = DiagnosisVerdict::kUnexplained;
  d.unexplained = {{"acceleration", 20.0, {}}};
  EXPECT_THAT(nextExperiment(d, minutesOfLog(1.0)), HasSubstr("slow and with fast starts"));
  d.unexplained = {{"humidity_percent", 20.0, {}}};
  EXPECT_THAT(nextExperiment(d, minutesOfLog(1.0)), HasSubstr("at several values of humidity_percent"));
}

TEST(LogConclusion, WhatIsLeftThroughoutAndFollowsNoChannelIsUnexplained) {
  Diagnosis d;
  d.baseline.mse_heldout = d.extended.mse_heldout = 0.16 * 0.16;
  d.noise_floor = 0.04 * 0.04;
  d.left_over_percent = 94.0;
  conclude(d);
  EXPECT_EQ(d.verdict, DiagnosisVerdict::kUnexplained);
  EXPECT_THAT(d.sentence, HasSubstr("Left: 94 % of the squared error, 4.0 times the noise, which no logged channel "
                                    "explains"));
  EXPECT_THAT(nextExperiment(d, minutesOfLog(2.0)), HasSubstr("log what else acts on the rig"));
}

TEST(LogConclusion, WhatIsTheSameInAllRowsIsAnOffset) {
  Diagnosis d;
  d.baseline.mse_heldout = d.extended.mse_heldout = 0.16 * 0.16;
  d.noise_floor = 0.04 * 0.04;
  d.left_over_percent = 94.0;
  d.unexplained = {{"an offset", 0.94, {}}};
  conclude(d);
  EXPECT_THAT(d.sentence, HasSubstr("Left: 94 % of the squared error, by an offset"));
  EXPECT_THAT(nextExperiment(d, minutesOfLog(2.0)), HasSubstr("approached from either side"));
}

TEST(LogConclusion, TheChannelThatCarriesMostIsNamedFirst) {
  Selection selection;
  Ceiling left;
  left.share = 0.5;
  left.channels = {{"motor_velocity", 0.1, {}}, {"temperature", 0.4, {}}};
  Diagnosis d;
  d.explained_percent = 0.0;
  sayWhatIsLeft(selection, minutesOfLog(1.0), left, d);
  ASSERT_EQ(d.unexplained.size(), 2u);
  EXPECT_EQ(d.unexplained[0].channel, "temperature");
  conclude(d);
  EXPECT_THAT(d.sentence, HasSubstr("by temperature."));
  d.unexplained[1].share = 0.9 * d.unexplained[0].share;
  conclude(d);
  EXPECT_THAT(d.sentence, HasSubstr("by temperature and motor_velocity.")) << "as much";
}

TEST(LogConclusion, AnUnknownNoiseIsNoYardstick) {
  EXPECT_THAT(withoutCauses(0.16, 0.0).sentence, Not(HasSubstr("no logged channel explains")));
}

}  // namespace
}  // namespace simgap
