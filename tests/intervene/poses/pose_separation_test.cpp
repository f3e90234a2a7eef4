// Poses that tell the models of a diagnosis apart: what is promised is what further poses of the model deliver.
#include "simgap/intervene/poses/pose_separation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "intervene/poses/judged_rig.h"
#include "support/files.h"

namespace simgap::test {
namespace {

const std::vector<std::string> kAlike = {"payload:link2", "passive-joint-torque:joint2", "gravity-tilt"};

Judged judged() { return {seedOfAForearm(), {.poses = 20, .fresh = 12, .effect = "payload"}, kAlike}; }

/// Four poses chosen for it: played with the models' drawn parameters, which takes a while.
const PoseSeparation& chosen() {
  static const PoseSeparation result = separatePoses(judged().evidence, {.candidates = 60, .poses = 4, .seed = 3});
  return result;
}

TEST(PoseSeparation, ChosenPosesPromiseMoreThanRandomOnes) {
  const PoseSeparation& result = chosen();
  ASSERT_EQ(result.poses.size(), 4u);
  ASSERT_EQ(result.pairs.size(), 4u);  // two rivals, either way
  for (std::size_t k = 1; k < 4; ++k) EXPECT_GE(result.smallest[k], result.smallest[k - 1]);
  EXPECT_GT(result.smallest.back(), 1.2 * result.smallest_random.back());
}

TEST(PoseSeparation, PromisesWhatJudgingThosePosesGives) {
  // Recorded without noise where the named model expects them, the odds are of the size promised to it: what is
  // promised scatters by the noise and by what is left open, sqrt(2 m) for normal predictions, and one of them is drawn
  // here.
  const Judged arm = judged();
  const PoseSeparation& result = chosen();
  const Intervention told = judgeChange(arm.evidence, {"further poses", {}}, {"next.csv", result.poses});
  for (const SeparatedPair& pair : result.pairs) {
    if (pair.right != 0) continue;
    const double scatter = 2.0 * std::sqrt(2.0 * std::max(0.0, pair.log_odds)) + 1.0;
    EXPECT_NEAR(-told.predictions[pair.wrong].log_odds, pair.log_odds, scatter);
  }
  EXPECT_GT(result.promised, result.promised_random);
}

TEST(PoseSeparation, IsTheSameForAnyNumberOfThreads) {
  Judged arm = judged();
  arm.evidence.threads = 1;
  const PoseSeparation one = separatePoses(arm.evidence, {.candidates = 30, .poses = 2, .seed = 3});
  arm.evidence.threads = 3;
  const PoseSeparation three = separatePoses(arm.evidence, {.candidates = 30, .poses = 2, .seed = 3});
  EXPECT_EQ(one.smallest, three.smallest);
  EXPECT_EQ(one.poses[1].shafts, three.poses[1].shafts);
}

TEST(PoseSeparation, RefusesWhereNothingContradicts) {
  Judged arm = judged();
  arm.evidence.candidates.resize(1);
  EXPECT_NE(errorOf([&] { separatePoses(arm.evidence, {}); }).find("there is nothing to tell apart"),
            std::string::npos);
}

}  // namespace
}  // namespace simgap::test
