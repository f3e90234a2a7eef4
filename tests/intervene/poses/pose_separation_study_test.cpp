// The study: poses are recorded until one name is left, those that `design --separate` chooses against random ones. The
// arm is another program's; models are the hidden cause and its look-alikes (docs/studies/interventions.md keeps the
// latest figures).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "intervene/poses/judged_rig.h"
#include "simgap/intervene/poses/pose_separation.h"

namespace simgap::test {
namespace {

constexpr int kRecorded = 16, kMost = 12;
constexpr double kDecided = 3.0;  // log odds over every other model

struct Race {
  int poses = kMost + 1;  ///< until one name was left; more than kMost: never
  bool right = false;     ///< it is the hidden one
  /// shape (candidates): log odds of the hidden cause over each, from all kMost new poses
  std::vector<double> reached;
};

/// Judges the first 1, 2 … of the fresh poses, those before them counted.
Race raceOf(const PoseEvidence& evidence, const std::string& truth, const PoseSet& fresh) {
  Race race;
  for (int k = 1; k <= kMost; ++k) {
    PoseSet first = fresh;
    first.poses.resize(k);
    const Intervention said = judgeChange(evidence, {"further poses", {}}, first);
    std::vector<double> odds;
    for (const CandidatePrediction& p : said.predictions) odds.push_back(p.log_odds + p.log_odds_before);
    const auto best = static_cast<std::size_t>(std::ranges::max_element(odds) - odds.begin());
    double second = -1e300, hidden = 0.0;
    for (std::size_t c = 0; c < odds.size(); ++c) {
      if (c != best) second = std::max(second, odds[c]);
      if (evidence.candidates[c].causes == truth) hidden = said.predictions[c].log_odds;
    }
    race.reached.clear();
    for (const CandidatePrediction& p : said.predictions) race.reached.push_back(hidden - p.log_odds);
    if (race.poses <= kMost || odds[best] - second < kDecided) continue;
    race.poses = k;
    race.right = evidence.candidates[best].causes == truth;
  }
  return race;
}

/// What was promised of pairs whose right model is the hidden cause, and what recording the poses gave.
struct Promises {
  std::vector<double> promised, reached;

  void add(const PoseEvidence& evidence, const std::string& truth, const PoseSeparation& next, const Race& race) {
    for (const SeparatedPair& pair : next.pairs) {
      if (evidence.candidates[pair.right].causes != truth) continue;
      promised.push_back(pair.log_odds);
      reached.push_back(race.reached[pair.wrong]);
      std::printf("      over %s: promised %.1f, reached %.1f\n", evidence.candidates[pair.wrong].causes.c_str(),
                  promised.back(), reached.back());
    }
  }
  /// Log odds m of normal predictions scatter by sqrt(2 m). \returns how many lie within two of that, and one
  int kept() const {
    int count = 0;
    for (std::size_t k = 0; k < promised.size(); ++k) {
      const double scatter = 1.0 + 2.0 * std::sqrt(2.0 * std::max(0.0, promised[k]));
      count += std::abs(reached[k] - promised[k]) < scatter ? 1 : 0;
    }
    return count;
  }
};

double middle(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
  return values[values.size() / 2];
}

TEST(SlowSeparationStudy, FewerPosesUntilOneNameIsLeft) {
  const std::vector<std::string> effects = {"payload", "passive-joint-torque", "gravity-tilt", "joint-centre-offset"};
  constexpr int kCases = 40;
  std::vector<double> designed, random;
  Promises promises;
  int right = 0, right_random = 0, asked = 0;
  for (std::uint64_t seed = 900; static_cast<int>(designed.size()) < kCases && seed < 1100; ++seed) {
    const std::string& effect = effects[seed % effects.size()];
    reality::PoseDrawOptions options{.poses = kRecorded, .fresh = kMost, .weak = true, .effect = effect};
    options.change = [](reality::Arm&) {};  // later, as all that is recorded afterwards
    const reality::PoseDraw draw = reality::drawPoses(seed, options);
    const std::string truth = labelOf(draw.hidden[0].effect, draw.hidden[0].target);
    std::vector<std::string> names = {"payload:link2", "passive-joint-torque:joint2", "gravity-tilt",
                                      "joint-centre-offset:joint2"};
    if (std::ranges::find(names, truth) == names.end()) names.push_back(truth);
    Judged judged(seed, options, names);
    std::ranges::stable_sort(judged.evidence.candidates, std::greater<>(), &CandidateModel::log_odds);
    const double named = judged.evidence.candidates[0].log_odds;
    for (CandidateModel& candidate : judged.evidence.candidates) candidate.log_odds -= named;
    ++asked;
    if (judged.evidence.candidates[1].log_odds < -kDecided) continue;  // told already
    const PoseSeparation next = separatePoses(judged.evidence, {.candidates = 150, .poses = kMost, .seed = seed});
    reality::PoseDrawOptions commanded = options;
    for (const Pose& pose : next.poses) commanded.commands.push_back(pose.shafts);
    const Race by_design = raceOf(judged.evidence, truth, posesOf(draw, reality::drawPoses(seed, commanded).fresh));
    const Race by_chance = raceOf(judged.evidence, truth, judged.after());
    designed.push_back(by_design.poses);
    random.push_back(by_chance.poses);
    right += by_design.right;
    right_random += by_chance.right;
    std::printf("  %lu %s: %d poses (%s), random %d (%s)\n", static_cast<unsigned long>(seed), truth.c_str(),
                by_design.poses, by_design.right ? "right" : "wrong", by_chance.poses,
                by_chance.right ? "right" : "wrong");
    promises.add(judged.evidence, truth, next, by_design);
    std::fflush(stdout);
  }
  ASSERT_FALSE(designed.empty());
  std::printf("%zu of %d sets undecided; poses until one name is left, median: %g, random %g; right %d, random %d\n",
              designed.size(), asked, middle(designed), middle(random), right, right_random);
  std::printf(
      "of %zu pairs with the hidden cause, median log odds promised %.2f, reached %.2f; within the scatter %d\n",
      promises.promised.size(), middle(promises.promised), middle(promises.reached), promises.kept());
  EXPECT_GE(static_cast<int>(designed.size()), kCases);
  EXPECT_GE(middle(random), 2 * middle(designed));
  EXPECT_GE(right, right_random);
  EXPECT_GE(promises.kept(), 0.85 * static_cast<double>(promises.promised.size()));
}

}  // namespace
}  // namespace simgap::test
