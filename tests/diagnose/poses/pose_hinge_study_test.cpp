// Faults of hinges on arms of several kinds: how often they are named, and what was named in their place while the
// catalogue did not have them (docs/studies/diagnose-poses.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "reality/revolute_arms.h"
#include "simgap/model/arm/arm_effect.h"
#include "support/drawn_poses.h"

namespace simgap {
namespace {

/// The catalogue without one effect.
std::vector<std::string> allBut(const std::string& effect) {
  std::vector<std::string> names;
  for (const ArmEffect* known : arm_effects::all()) {
    if (known->name != effect && !known->needs_motion) names.emplace_back(known->name);
  }
  return names;
}

struct HingeRates {
  int sets = 0, silent = 0, alone = 0, in_group = 0, wrong = 0;

  void count(const std::string& truth, const Diagnosis& found) {
    ++sets;
    std::vector<Cause> named = found.causes;
    std::erase_if(named, [&](const Cause& c) { return c.effect == "joint-stiction" && !truth.starts_with(c.effect); });
    bool listed = false, only = named.size() == 1;
    for (const Cause& cause : named) {
      const bool right = labelOf(cause) == truth;
      const bool in = std::ranges::find(cause.ambiguous_with, truth) != cause.ambiguous_with.end();
      only = only && right && cause.ambiguous_with.empty();
      listed = listed || right || in;
    }
    silent += named.empty();
    alone += only;
    in_group += listed && !only;
    wrong += !named.empty() && !listed;
  }
  void print(const char* title) const {
    std::printf("%s: %d sets, alone %d, in a group or with another %d, wrong %d, silent or unexplained %d\n", title,
                sets, alone, in_group, wrong, silent);
  }

 private:
  static std::string labelOf(const Cause& cause) { return test::labelOf(cause.effect, cause.target); }
};

/// \param hidden  empty: nothing is hidden
HingeRates studyHinges(const std::string& hidden, std::uint64_t first, int sets, const std::string& left_out = "") {
  const reality::Arm arms[] = {reality::threeHingeArm(), reality::referenceArm(), reality::threeHingeArm(),
                               reality::planarArm()};
  HingeRates rates;
  for (int i = 0; i < sets; ++i) {
    reality::PoseDrawOptions draw_options;
    draw_options.poses = 60;
    draw_options.causes = hidden.empty() ? 0 : 1;
    draw_options.effect = hidden;
    draw_options.arm = &arms[i % 4];
    const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
    const reality::PoseDraw draw = reality::drawPoses(seed, draw_options);
    const std::string truth = hidden.empty() ? "none" : test::labelOf(hidden, draw.hidden[0].target);
    PoseDiagnosisOptions options;
    if (!left_out.empty()) options.effects = allBut(left_out);
    const Diagnosis found = test::diagnose(draw, options).diagnosis;
    rates.count(truth, found);
    std::printf("  %d %s (%.3f): %s, %s\n", static_cast<int>(seed), truth.c_str(),
                hidden.empty() ? 0.0 : draw.hidden[0].magnitude, toString(found.verdict).data(),
                found.sentence.c_str());
    for (const Cause& cause : found.causes) {
      for (const std::string& other : cause.ambiguous_with) std::printf("      or %s\n", other.c_str());
    }
    std::fflush(stdout);
  }
  return rates;
}

TEST(SlowHinges, NothingHiddenIsSilent) {
  const HingeRates rates = studyHinges("", 1300, 8);
  rates.print("nothing hidden");
  EXPECT_EQ(rates.wrong, 0);
}

TEST(SlowHinges, AxesAreNamedOrInAGroup) {
  const HingeRates without = studyHinges("joint-axis", 1400, 8, "joint-axis");
  without.print("axes, without the cause");
  const HingeRates rates = studyHinges("joint-axis", 1400, 8);
  rates.print("axes");
  EXPECT_EQ(rates.wrong, 0);
  EXPECT_GE(rates.alone + rates.in_group, 1);  // the parameters of a fit take most of them up
}

}  // namespace
}  // namespace simgap
