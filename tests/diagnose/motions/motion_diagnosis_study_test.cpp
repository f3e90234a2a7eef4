// How often a diagnosis of motions is right: forearms drawn and moved by the independent simulator, off from their
// models by what a static calibration leaves, with nothing or one cause hidden. The table of
// docs/studies/diagnose-motions.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>

#include "diagnose/motions/motion_cases.h"

namespace simgap {
namespace {

constexpr std::uint64_t kFirstForearm = 126, kForearms = 10;
constexpr double kWorthFinding = 0.05;  // of the held-out mean square

/// silent, right, group (the right one among others), unexplained, WRONG.
std::string judgedAs(const Diagnosis& said, const std::string& effect, const std::string& target) {
  const std::string label = effect + (target.empty() ? "" : ":") + target;
  if (said.causes.empty()) return said.verdict == DiagnosisVerdict::kUnexplained ? "unexplained" : "silent";
  const auto labelOf = [](const Cause& c) { return c.target.empty() ? c.effect : c.effect + ":" + c.target; };
  const Cause& first = said.causes.front();
  const bool among =
      labelOf(first) == label || std::ranges::find(first.ambiguous_with, label) != first.ambiguous_with.end();
  if (!among || said.causes.size() > 1) return "WRONG";
  return first.ambiguous_with.empty() ? "right" : "group";
}

std::string causesOf(const Diagnosis& said) {
  std::string text;
  for (const Cause& cause : said.causes) {
    text += " " + cause.effect + ":" + cause.target;
    for (const std::string& rival : cause.ambiguous_with) text += "|" + rival;
    for (const Estimate& p : cause.parameters) {
      char value[96];
      std::snprintf(value, sizeof value, " %s=%.4g [%.4g, %.4g]", p.name.c_str(), p.value, p.lower95, p.upper95);
      text += value;
    }
  }
  for (const Candidate& candidate : said.candidates)
    text += " (candidate " + candidate.effect + ":" + candidate.target + ": " + candidate.reason + ")";
  return text;
}

TEST(SlowMotionDiagnosisStudy, NamesWhatIsHidden) {
  std::map<std::string, int> nothing, hidden, outside;
  int holding = 0, intervals = 0;
  for (std::uint64_t seed = kFirstForearm; seed < kFirstForearm + kForearms; ++seed) {
    double noise = 1.0;  // what is missed of held-out motions with nothing hidden
    for (const test::MotionTruth& cause : test::motionTruths()) {
      const test::MotionCase one = test::diagnoseForearmWith(cause, seed);
      const Diagnosis& said = one.said.diagnosis;
      const std::string outcome = judgedAs(said, cause.effect, one.hidden.target), effect = cause.effect;
      if (effect.empty()) noise = said.baseline.mse_heldout;
      const double worth = 1.0 - noise / said.baseline.mse_heldout;
      std::printf("%lu %s:%s %.4g worth %.3f: %s; heldout %.3f -> %.3f;%s; %ld rollouts\n", seed, cause.effect,
                  one.hidden.target.c_str(), one.hidden.magnitude, worth, outcome.c_str(), said.baseline.mse_heldout,
                  said.extended.mse_heldout, causesOf(said).c_str(), one.said.rollouts);
      std::fflush(stdout);
      ++(effect.empty() ? nothing : effect == "drag" ? outside : worth >= kWorthFinding ? hidden : nothing)[outcome];
      if (outcome != "right") continue;
      const Estimate& value = said.causes.front().parameters.front();
      ++intervals;
      holding += value.lower95 <= one.hidden.magnitude && one.hidden.magnitude <= value.upper95;
    }
  }
  for (const auto& [name, counts] :
       {std::pair{"nothing or small", &nothing}, {"one cause", &hidden}, {"outside", &outside}}) {
    std::printf("%s:", name);
    for (const auto& [outcome, times] : *counts) std::printf(" %s %d", outcome.c_str(), times);
    std::printf("\n");
  }
  std::printf("intervals that hold: %d of %d\n", holding, intervals);
  const auto of = [](const std::map<std::string, int>& counts) {
    int sum = 0;
    for (const auto& [outcome, times] : counts) sum += times;
    return sum;
  };
  EXPECT_LE(nothing["WRONG"], 0.05 * of(nothing));
  EXPECT_EQ(hidden["WRONG"], 0);
  EXPECT_GE(hidden["right"], 0.9 * of(hidden));
  EXPECT_GE(hidden["right"] + hidden["group"], 0.97 * of(hidden));
  EXPECT_EQ(outside["unexplained"], of(outside));
  EXPECT_GE(holding, 0.9 * intervals);
}

}  // namespace
}  // namespace simgap
