// Causes hidden in simulated arms must be found, and nothing where nothing is hidden. The arms, their magnitudes and
// their noise are drawn by tests/reality/pose_draws.cpp, which shares no code with the models; the diagnosis sees the
// two files.
#include "simgap/diagnose/poses/pose_diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "simgap/model/arm/arm_yaml.h"
#include "support/drawn_poses.h"
#include "support/files.h"

namespace simgap {
namespace {

using test::diagnose, test::labelOf;

struct Hidden {
  std::uint64_t seed;
  std::string effect;
};

class PoseDiagnosisOf : public testing::TestWithParam<Hidden> {};

TEST_P(PoseDiagnosisOf, NamesTheHiddenCause) {
  reality::PoseDrawOptions options;
  options.effect = GetParam().effect;
  const reality::PoseDraw draw = reality::drawPoses(GetParam().seed, options);
  const Diagnosis found = diagnose(draw).diagnosis;
  ASSERT_EQ(found.verdict, DiagnosisVerdict::kCauseFound) << found.sentence;
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(labelOf(found.causes[0].effect, found.causes[0].target),
            labelOf(draw.hidden[0].effect, draw.hidden[0].target));
  // 20 poses measure a gain to some 15 %, so that a real one of 10 % can look like 4 %; it must not look like none.
  EXPECT_GT(found.causes[0].gain_heldout.upper95, 0.05);
  EXPECT_LT(found.extended.mse_heldout, found.baseline.mse_heldout);
  EXPECT_FALSE(found.next_experiment.empty());
  EXPECT_FALSE(found.evidence.empty());
}

std::string caseName(const testing::TestParamInfo<Hidden>& tested) {
  std::string name = tested.param.effect + std::to_string(tested.param.seed);
  std::erase(name, '-');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Arms, PoseDiagnosisOf,
                         testing::Values(Hidden{11, "payload"}, Hidden{11, "gravity-tilt"},
                                         Hidden{11, "potentiometer-slip"}, Hidden{41, "muscle-wrap"}),
                         caseName);

TEST(PoseDiagnosis, FindsNothingWhereNothingIsHidden) {
  reality::PoseDrawOptions options;
  options.causes = 0;
  const Diagnosis found = diagnose(reality::drawPoses(21, options)).diagnosis;
  EXPECT_EQ(found.verdict, DiagnosisVerdict::kNothingFound) << found.sentence;
  EXPECT_TRUE(found.causes.empty());
  EXPECT_GT(found.detectable.size(), 30u);
}

// A wrap of the triceps. The poses selected with like a spring at the elbow, odds of 10; all of them together do not.
TEST(PoseDiagnosis, TakesBackWhatAllPosesTogetherDeny) {
  const Diagnosis found = diagnose(reality::drawPoses(829, {})).diagnosis;
  const auto taken_back = [](const HypothesisRecord& record) {
    return record.outcome.starts_with("rejected") && record.outcome.ends_with("by all poses");
  };
  EXPECT_TRUE(std::ranges::any_of(found.hypotheses, taken_back)) << found.sentence;
  EXPECT_TRUE(found.causes.empty()) << found.sentence;
}

TEST(PoseDiagnosis, NamesFlippedPosesAndStopsUnlessToldToGoOn) {
  reality::PoseDrawOptions options;
  options.causes = 0;
  options.poses = 40;
  options.flipped = 2;
  const reality::PoseDraw draw = reality::drawPoses(23, options);
  PoseDiagnosisOptions quick;
  quick.effects = {"payload"};
  const Diagnosis stopped = diagnose(draw, quick).diagnosis;
  EXPECT_EQ(stopped.verdict, DiagnosisVerdict::kDataFault);
  ASSERT_EQ(stopped.faults.size(), 1u);
  EXPECT_EQ(stopped.faults[0].rows, 2u) << stopped.faults[0].sentence;
  quick.ignore_faults = true;
  const Diagnosis went_on = diagnose(draw, quick).diagnosis;
  EXPECT_EQ(went_on.verdict, DiagnosisVerdict::kNothingFound) << went_on.sentence;
  EXPECT_TRUE(went_on.faults[0].corrected);
}

// The same arm with and without two elbow angles that were read wrong by 8 deg, some 25 deviations.
TEST(PoseDiagnosis, ReadingsThatAreAloneInBeingWrongAreLeftOut) {
  reality::PoseDrawOptions options;
  options.effect = "payload";
  options.poses = 48;
  const reality::PoseDraw draw = reality::drawPoses(11, options);
  PoseSet set = test::posesOf(draw, draw.poses);
  for (const std::size_t p : {13u, 30u}) set.poses[p].joints[1].angle += 8.0 * kDegree;
  const CalibrationConfig& config = test::paperConfig();
  PoseDiagnosisOptions quick;
  quick.effects = {"payload", "gravity-tilt"};
  const Diagnosis found =
      diagnosePoses(test::modelOf(draw), set, config.parameters, config.noise, quick, [](const std::string&, double) {
      }).diagnosis;
  ASSERT_EQ(found.faults.size(), 1u);
  EXPECT_TRUE(found.faults[0].corrected);
  EXPECT_EQ(found.faults[0].rows, 2u) << found.faults[0].sentence;
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "payload");
}

TEST(PoseDiagnosis, IsTheSameForAnyNumberOfThreads) {
  reality::PoseDrawOptions options;
  options.effect = "payload";
  options.poses = 32;
  const reality::PoseDraw draw = reality::drawPoses(31, options);
  PoseDiagnosisOptions one;
  one.effects = {"payload", "gravity-tilt"};
  PoseDiagnosisOptions three = one;
  one.threads = 1;
  three.threads = 3;
  const PoseDiagnosis a = diagnose(draw, one), b = diagnose(draw, three);
  EXPECT_EQ(writeArm(a.model), writeArm(b.model));
  EXPECT_EQ(a.diagnosis.extended.mse_heldout, b.diagnosis.extended.mse_heldout);
}

TEST(PoseDiagnosis, RefusesUnknownEffectsAndTooFewPoses) {
  reality::PoseDrawOptions options;
  options.causes = 0;
  options.poses = 9;  // of which 7 would select causes
  const reality::PoseDraw draw = reality::drawPoses(1, options);
  EXPECT_THAT(test::errorOf([&] { diagnose(draw); }), testing::HasSubstr("found 9 poses, expected at least 10"));
  PoseSet copies{"copies.csv", std::vector<Pose>(60)};
  EXPECT_THAT(test::errorOf([&] { requireEnough(copies, {}); }), testing::HasSubstr("found 1 different poses"));
  PoseDiagnosisOptions wrong;
  wrong.effects = {"muscle-warp"};
  EXPECT_THAT(test::errorOf([&] { diagnose(draw, wrong); }), testing::HasSubstr("found 'muscle-warp'"));
  wrong.effects = {"command-latency"};
  EXPECT_THAT(test::errorOf([&] { diagnose(draw, wrong); }), testing::HasSubstr("it takes --motions"));
}

}  // namespace
}  // namespace simgap
