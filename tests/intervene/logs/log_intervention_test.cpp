// Logs after a change of the bench judge the models of a diagnosis, with nothing refitted. The bench is another
// program's (tests/reality).
#include "simgap/intervene/logs/log_intervention.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnose/logs/log_candidates.h"
#include "diagnose/logs/prepared_logs.h"
#include "intervene/logs/bench_constants.h"
#include "simgap/diagnose/logs/refitted_model.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

reality::DriveSecret biased() {
  reality::DriveSecret secret;
  secret.current_bias = 0.5;
  return secret;
}

reality::DriveRig rigOf(std::uint64_t seed) {
  reality::DriveRig rig = smallRig(6000);
  rig.seed = seed;
  return rig;
}

CsvTable logOf(const reality::DriveRig& rig, const reality::DriveSecret& secret) {
  return CsvTable::parse(reality::recordDrive(rig, secret).csv(), "after.csv");
}

/// What the diagnosis of a log with a biased current knew, of a few causes.
const LogEvidence& evidence() {
  static const LogEvidence found = [] {
    const std::string csv = reality::recordDrive(rigOf(11), biased()).csv();
    PreparedLog log = prepareLog(CsvTable::parse(csv, "log.csv"), {}, ActuatorKind::kFriction);
    LogDiagnosisOptions options;
    options.effects = {"current-bias", "direction-asymmetry", "torque-bias", "coulomb-offset"};
    const ActuatorModel subject = subjectOf("classic");
    const LogDiagnosis diagnosis = diagnoseLog(subject, log, options);
    LogEvidence evidence;
    for (const FittedLogCandidate& c : diagnosis.candidates) {
      evidence.candidates.push_back({c.candidate, refittedModel({}, subject, c.fit, log, {"log.csv", "", 6000})});
    }
    evidence.correlation_s = diagnosis.correlation_s;
    evidence.reference = csv;
    evidence.reference_file = "log.csv";
    return evidence;
  }();
  return found;
}

/// The same with another candidate believed.
LogEvidence believing(const std::string& causes) {
  LogEvidence other = evidence();
  for (std::size_t c = 0; c < other.candidates.size(); ++c) {
    if (other.candidates[c].known.causes != causes) continue;
    std::swap(other.candidates[0], other.candidates[c]);
    return other;
  }
  ADD_FAILURE() << "no candidate " << causes;
  return other;
}

LogChanges changeOf(const std::string& yaml) {
  return LogChanges::read(YamlNode::parse("format: simgap/change/1\nchanges:\n" + yaml, "change.yaml"));
}

TEST(BenchConstants, AreNoLessThanNothing) {
  LogSetting setting;
  setting.bench.mass.value = 1.0;
  changeConstant(setting, &BenchConstants::mass, -0.4, "mass");
  EXPECT_NEAR(setting.bench.mass.value, 0.6, 1e-12);
  EXPECT_THAT(errorOf([&] { changeConstant(setting, &BenchConstants::mass, -5.0, "mass"); }),
              HasSubstr("found a change of mass by -5 where the bench has 0.6"));
}

TEST(LogIntervention, TheDiagnosisKeepsTheModelsThatWouldHaveComeNext) {
  ASSERT_GE(evidence().candidates.size(), 3u);
  EXPECT_EQ(evidence().candidates[0].known.causes, "current-bias");
  EXPECT_EQ(evidence().candidates[0].known.role, "named");
  EXPECT_EQ(evidence().candidates.back().known.causes, "none");
  EXPECT_LT(evidence().candidates.back().known.posterior.log_odds, -3.0);
}

TEST(LogIntervention, ConfirmsTheCauseThatWasTakenAway) {
  const LogIntervention result =
      judgeChange(evidence(), changeOf("  - {kind: undo, cause: current-bias}\n"), logOf(rigOf(12), {}));
  EXPECT_EQ(result.verdict, InterventionVerdict::kConfirmed) << result.sentence;
  EXPECT_GT(result.predictions[0].p, 0.01);
  EXPECT_LT(result.predictions.back().log_odds, -3.0);
  EXPECT_EQ(result.unit, "A");
}

TEST(LogIntervention, RefutesALookAlikeWhoseRemovalChangedNothing) {
  std::string alike;
  for (const LogEvidence::Candidate& c : evidence().candidates) {
    if (c.known.role == "instead") alike = c.known.causes;
  }
  ASSERT_FALSE(alike.empty());
  const LogIntervention result =
      judgeChange(believing(alike), changeOf("  - {kind: undo, cause: " + alike + "}\n"), logOf(rigOf(12), biased()));
  EXPECT_EQ(result.verdict, InterventionVerdict::kRefuted) << result.sentence;
  EXPECT_THAT(result.sentence, HasSubstr("current-bias predicts these rows"));
}

TEST(LogIntervention, KnowsAnAmplifierThatWasExchangedAndHowWell) {
  reality::DriveRig stronger = rigOf(12);
  stronger.torque_per_ampere *= 1.3;
  const CsvTable after = logOf(stronger, biased());
  const auto pOf = [&](const std::string& yaml) {
    return judgeChange(evidence(), changeOf(yaml), after).predictions[0].p;
  };
  const double told = pOf("  - {kind: gain, factor: 1.3}\n"), untold = pOf("  - {kind: gain, factor: 1.0}\n");
  EXPECT_GT(told, 0.01);
  EXPECT_LT(untold, 1e-6);
  EXPECT_GT(pOf("  - {kind: gain, factor: 1.0, factor_sd: 0.3}\n"), 100.0 * untold);
  const LogIntervention none = judgeChange(evidence(), changeOf("  - {kind: gain, factor: 1.0}\n"), after);
  EXPECT_EQ(none.verdict, InterventionVerdict::kCannotTell) << none.sentence;
  EXPECT_THAT(none.sentence, HasSubstr("none of 4 models predicts these rows"));
}

/// A current that jerks at first, by `ampere` in rows 5 to 14.
CsvTable jerked(reality::DriveRig rig, const reality::DriveSecret& secret, std::size_t rows, double ampere) {
  rig.rows = 6000;
  reality::DriveRecord record = reality::recordDrive(rig, secret);
  for (std::size_t i = 5; i < 15; ++i) record.current[i] += ampere;
  return CsvTable::parse(firstLines(record.csv(), rows + 1), "after.csv");
}

// The diagnosis was right and nothing was changed. A model that explains little expects large errors everywhere, also
// where a jerk makes them; the one that knows better is not refuted by two seconds.
TEST(LogIntervention, NoVerdictHangsOnTwoSeconds) {
  for (const std::size_t rows : {60, 200, 400}) {
    const LogIntervention result = judgeChange(evidence(), {}, jerked(rigOf(12), biased(), rows, 3.0));
    EXPECT_NE(result.verdict, InterventionVerdict::kRefuted) << rows << " rows: " << result.sentence;
  }
  const LogIntervention few = judgeChange(evidence(), {}, jerked(rigOf(12), biased(), 60, 0.0));
  EXPECT_EQ(few.verdict, InterventionVerdict::kCannotTell) << few.sentence;
}

// Rows that are far from every model, in the eyes of the one that knows best, are left out.
TEST(LogIntervention, ModelsThatExplainLittleKeepNoOutliers) {
  const double best = std::sqrt(evidence().candidates.front().known.posterior.variance),
               least = std::sqrt(evidence().candidates.back().known.posterior.variance);
  const LogIntervention result = judgeChange(evidence(), {}, jerked(rigOf(12), biased(), 6000, 12.0 * best));
  EXPECT_GE(result.left_out, 8u) << best << " A of the named one, " << least << " A without a cause; " << result.rows;
  EXPECT_EQ(result.verdict, InterventionVerdict::kConfirmed) << result.sentence;
}

TEST(LogIntervention, ForeseesWhichChangeTells) {
  const ForeseenLogChange off = foreseeChange(evidence(), changeOf("  - {kind: undo, cause: current-bias}\n"));
  const ForeseenLogChange same = foreseeChange(evidence(), changeOf("  - {kind: speed, factor: 1.0}\n"));
  const std::size_t last = evidence().candidates.size() - 1;
  EXPECT_EQ(off.log_odds[0][0], 0.0);
  EXPECT_GT(off.log_odds[0][last] + same.log_odds[0][last], 3.0);
  // Half the bias is the most that any prediction without it can be off by a constant.
  EXPECT_NEAR(same.largest_shift[last] / 0.5, 1.0, 0.9);
  EXPECT_THAT(off.where[last], HasSubstr("rad/s"));
  const ForeseenLogChange loaded = foreseeChange(evidence(), changeOf("  - {kind: load, factor: 2}\n"));
  EXPECT_NEAR(loaded.predicted[0].abs().maxCoeff() / same.predicted[0].abs().maxCoeff(), 2.0, 0.3);
}

TEST(LogIntervention, RefusesWhatTheBenchCannotDo) {
  const auto sentence = [&](const char* yaml) {
    return errorOf([&] { static_cast<void>(foreseeChange(evidence(), changeOf(yaml))); });
  };
  EXPECT_THAT(sentence("  - {kind: undo, cause: bend-friction}\n"),
              HasSubstr("found 'bend-friction' to undo, which no model of the diagnosis holds; expected one of "));
  EXPECT_THAT(sentence("  - {kind: undo, cause: rust}\n"), HasSubstr("change.yaml:3"));
  EXPECT_THAT(sentence("  - {kind: mass, mass_kg: 1}\n"), HasSubstr("a bench whose load is measured"));
  EXPECT_THAT(sentence("  - {kind: length, longer_m: 1}\n"), HasSubstr("expected it on a pendulum only"));
  EXPECT_THAT(sentence("  - {kind: tilt, turn_rad: 0.1}\n"), HasSubstr("expected it on a pendulum only"));
  EXPECT_THAT(sentence("  - {kind: resistance, resistance_ohm: 1}\n"), HasSubstr("expected it of a winding"));
  EXPECT_THAT(sentence("  - {kind: gain, factor: 0}\n"), HasSubstr("a factor in [0.01, 100]"));
  EXPECT_THAT(sentence("  - {kind: paint}\n"), HasSubstr("paint"));
  EXPECT_THAT(sentence("  - {kind: gain, factor: 2, colour: red}\n"), HasSubstr("colour"));
}

TEST(LogIntervention, FreedomIsThatOfEqualPieces) {
  // Pieces whose mean squares scatter like chi-squared of 8: each tells 8.
  GroupErrors errors{Eigen::ArrayXd(4000), Eigen::ArrayXd::Constant(4000, 8.0)};
  std::uint64_t state = 7;
  const auto normal = [&] {  // sum of twelve uniform numbers
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      sum += static_cast<double>(state >> 11U) / 9007199254740992.0;
    }
    return sum;
  };
  for (double& sum : errors.sum) {
    sum = 0.0;
    for (int k = 0; k < 8; ++k) sum += std::pow(normal(), 2);
  }
  EXPECT_NEAR(freedomOf(errors) / 32000.0, 1.0, 0.15);
}

}  // namespace
}  // namespace simgap::test
