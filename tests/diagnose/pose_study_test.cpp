// The study: how often a diagnosis is right, over many drawn arms (docs/diagnose.md keeps the latest figures). The
// draws share no code with the models.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>

#include "../../src/diagnose/pose_evidence.h"
#include "../../src/diagnose/pose_selection.h"
#include "../../src/diagnose/pose_validation.h"
#include "support/drawn_poses.h"

namespace simgap {
namespace {

using test::labelOf;

constexpr double kWorthNaming = 0.05;  // of the squared error on fresh poses that the true model takes away

/// What the model with the true cause takes away from the squared error on fresh poses, everything fitted.
double trueGain(const reality::PoseDraw& draw) {
  const PoseProblem problem{test::modelOf(draw), test::paperConfig().parameters, test::paperConfig().noise, 0};
  const PoseSet set = test::posesOf(draw, draw.poses), fresh = test::posesOf(draw, draw.fresh);
  PoseFit plain(problem, set.poses, {});
  plain.search(8, 0, 1);
  std::vector<NotTestable> none;
  const reality::HiddenCause& hidden = draw.hidden[0];
  double lowest = std::numeric_limits<double>::infinity();
  ArmModel model;
  for (const PoseHypothesis& h : poseHypotheses(problem.nominal, set.poses, {hidden.effect}, none)) {
    if (h.target != hidden.target) continue;
    for (EffectParameters start : h.starts) {
      if (hidden.effect == "potentiometer-slip") start = {hidden.magnitude, hidden.moment};
      PoseFit with(problem, set.poses, {{h.effect, h.target, start}});
      with.posterior().whitenLike(plain.posterior());
      with.descend(with.extended(plain.z()));
      if (with.objective() >= lowest) continue;
      lowest = with.objective();
      model = with.model();
    }
  }
  const PoseErrors errors(problem, plain, fresh.poses);
  return pairedGain(errors.of(plain.model()), errors.of(model), 1).value;
}

struct Rates {
  int sets = 0, alone = 0, in_group = 0, covered = 0, intervals = 0;
  std::map<std::string, std::map<std::string, int>> confusion;

  void count(std::uint64_t seed, const reality::PoseDraw& draw, const Diagnosis& found) {
    const std::string truth = draw.hidden.empty() ? "none" : draw.hidden[0].effect;
    const std::string label = draw.hidden.empty() ? "" : labelOf(truth, draw.hidden[0].target);
    ++sets;
    std::string answer = found.causes.empty() ? std::string(toString(found.verdict)) : "";
    for (const Cause& cause : found.causes) {
      answer += (answer.empty() ? "" : " + ") + cause.effect;
      if (labelOf(cause.effect, cause.target) != label && cause.effect == truth) answer += " elsewhere";
      if (!cause.ambiguous_with.empty()) answer += " (ambiguous)";
    }
    ++confusion[truth][answer];
    std::printf("  %lu %s: %s\n", static_cast<unsigned long>(seed), draw.hidden.empty() ? "none" : label.c_str(),
                found.causes.empty() ? toString(found.verdict).data() : found.sentence.c_str());
    std::fflush(stdout);
    if (found.causes.size() != 1) return;
    const Cause& cause = found.causes[0];
    const bool right = labelOf(cause.effect, cause.target) == label;
    const bool listed = std::ranges::find(cause.ambiguous_with, label) != cause.ambiguous_with.end();
    alone += right && cause.ambiguous_with.empty();
    in_group += (right || listed) && cause.ambiguous_with.size() <= 2;
    for (std::size_t i = 0; right && i < draw.hidden[0].parameters.size(); ++i) {
      const Interval& interval = cause.parameters[i].value;
      const double value = draw.hidden[0].parameters[i];
      ++intervals;
      covered += interval.lower95 <= value && value <= interval.upper95;
    }
  }
  void print(const char* title) const {
    std::printf("%s: %d sets, named alone %d, in a group of at most 3 %d, parameters in their interval %d of %d\n",
                title, sets, alone, in_group, covered, intervals);
    for (const auto& [truth, answers] : confusion) {
      std::printf("  %-24s", truth.c_str());
      for (const auto& [answer, n] : answers) std::printf(" %d x %s;", n, answer.c_str());
      std::printf("\n");
    }
    std::fflush(stdout);
  }
};

TEST(SlowPoseDiagnosis, FalseAlarmsOfArmsWithoutCauses) {
  Rates rates;
  int alarms = 0;
  for (std::uint64_t seed = 1100; seed < 1140; ++seed) {
    reality::PoseDrawOptions options;
    options.causes = 0;
    const reality::PoseDraw draw = reality::drawPoses(seed, options);
    const Diagnosis found = test::diagnose(draw).diagnosis;
    rates.count(seed, draw, found);
    alarms += std::ranges::any_of(found.causes, [](const Cause& c) { return c.effect != "joint-stiction"; });
  }
  rates.print("nothing hidden");
  EXPECT_LE(alarms, 2) << "of 40";
}

TEST(SlowPoseDiagnosis, HiddenCausesAreNamed) {
  Rates strong, weak, slight;
  for (std::uint64_t seed = 1200; seed < 1260; ++seed) {
    reality::PoseDrawOptions options;
    options.weak = seed % 2 == 1;
    options.fresh = 40;
    const reality::PoseDraw draw = reality::drawPoses(seed, options);
    const double gain = trueGain(draw);
    std::printf("  gain of the true model on fresh poses %.1f %%:", 100.0 * gain);
    Rates& rates = gain < kWorthNaming ? slight : options.weak ? weak : strong;
    rates.count(seed, draw, test::diagnose(draw).diagnosis);
  }
  strong.print("strong, the true model gains 5 % or more");
  weak.print("weak, the true model gains 5 % or more");
  slight.print("the true model gains less");
  const int sets = strong.sets + weak.sets, intervals = strong.intervals + weak.intervals;
  EXPECT_GE(strong.alone + weak.alone, 0.9 * sets);
  EXPECT_GE(strong.in_group + weak.in_group, 0.97 * sets);
  EXPECT_GE(strong.covered + weak.covered, 0.85 * intervals);
}

}  // namespace
}  // namespace simgap
