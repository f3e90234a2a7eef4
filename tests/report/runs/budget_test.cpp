#include "simgap/report/runs/budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/result_folder.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

using ::testing::HasSubstr;

const Json kResult = {{"format", "simgap/diagnose/1"},
                      {"verdict", "cause-found"},
                      {"mje_deg", {{"final", {{"elbow", 2.5}}}}},
                      {"parameters",
                       {{{"name", "muscles.biceps.spindle_radius_m"}, {"value", 0.006}, {"sd", 0.0003}},
                        {{"name", "muscles.triceps.spindle_radius_m"}, {"value", 0.009}, {"sd", nullptr}},
                        {{"name", "k_a"}, {"value", 1e300}, {"sd", nullptr}, {"identifiable", false}}}},
                      {"causes",
                       {{{"effect", "channel-delay"},
                         {"target", "elbow"},
                         {"ambiguous_with", {"marker-frame-offset:chest"}},
                         {"gain_heldout_percent", 12.0}}}}};

Json check(const std::string& limits) {
  const test::ResultFolder folder(kResult);
  folder.directory().write("hypotheses.csv",
                           "step,effect,target\n1,channel-delay,elbow\n1,channel-delay,shoulder\n1,payload,\n"
                           "1,torque-saturation (knee),\n");
  return checkBudget(readBudget(YamlNode::parse("format: simgap/budget/1\nlimits:\n" + limits, "budget.yaml")),
                     ResultFiles(folder.directory().path()));
}

TEST(Budget, HoldsAndBreaks) {
  EXPECT_TRUE(holds(check("  - {value: mje_deg.final.elbow, upper: 3}\n")));
  EXPECT_FALSE(holds(check("  - {value: mje_deg.final.elbow, upper: 2}\n")));
  EXPECT_TRUE(holds(check("  - {parameter: '*.spindle_radius_m', lower: 0.005, upper: 0.01}\n")));
  EXPECT_FALSE(holds(check("  - {parameter: '*.spindle_radius_m', upper: 0.007}\n")));
  EXPECT_TRUE(holds(check("  - {parameter: 'muscles.b*_m', largest_sd_percent: 6}\n")));
  EXPECT_TRUE(holds(check("  - verdict: [nothing-found, cause-found]\n")));
  EXPECT_FALSE(holds(check("  - verdict: [nothing-found]\n")));
  EXPECT_FALSE(holds(check("  - {cause: channel-*}\n")));
  EXPECT_TRUE(holds(check("  - {cause: channel-delay, upper: 15}\n")));
  EXPECT_TRUE(holds(check("  - {cause: payload}\n")));
}

TEST(Budget, ACauseIsMeantWithItsTargetAndInAGroupToo) {
  EXPECT_FALSE(holds(check("  - {cause: 'channel-delay:elbow', upper: 10}\n")));
  EXPECT_TRUE(holds(check("  - {cause: 'channel-delay:shoulder'}\n")));
  EXPECT_FALSE(holds(check("  - {cause: marker-frame-offset}\n")));
  EXPECT_FALSE(holds(check("  - {cause: 'marker-frame-offset:chest'}\n")));
}

TEST(Budget, WhatIsNotThereDoesNotHold) {
  EXPECT_FALSE(holds(check("  - {value: mje_deg.final.shoulder, upper: 3}\n")));
  EXPECT_FALSE(holds(check("  - {value: mje_deg, upper: 3}\n")));
  EXPECT_FALSE(holds(check("  - {parameter: mass, upper: 3}\n")));
  EXPECT_FALSE(holds(check("  - {parameter: k_a, lower: 1}\n"))) << "not found";
  EXPECT_FALSE(holds(check("  - {parameter: 'muscles.triceps*', largest_sd_percent: 50}\n")));
}

TEST(Budget, ACauseThatWasNotAskedForIsNotExcluded) {
  EXPECT_TRUE(holds(check("  - {cause: torque-saturation}\n")));
  EXPECT_FALSE(holds(check("  - {cause: torque-saturatoin}\n")));
  EXPECT_FALSE(holds(check("  - {cause: 'channel-delay:wrist'}\n")));
  EXPECT_THAT(guardText(check("  - {cause: friction-heating}\n")), HasSubstr("the run did not ask for it"));
}

TEST(Budget, ARunThatFailedHoldsNothing) {
  const test::ResultFolder folder(kResult);
  RunRecord record({"simgap", "calibrate"}, 7, 1);
  record.write(folder.directory(), "failed: the result is worse than the start");
  const Json guard = checkBudget(
      readBudget(YamlNode::parse("format: simgap/budget/1\nlimits:\n  - {verdict: [cause-found]}\n", "budget.yaml")),
      ResultFiles(folder.directory().path()));
  EXPECT_FALSE(holds(guard));
  EXPECT_EQ(guard.at("held"), 1);
  EXPECT_THAT(guardText(guard), HasSubstr("failed: the result is worse than the"));
}

TEST(Budget, SaysWhichLineIsBroken) {
  const Json guard = check("  - {value: mje_deg.final.elbow, upper: 2}\n  - {cause: payload}\n");
  EXPECT_THAT(guardText(guard), HasSubstr("1 of 2 limits hold"));
  EXPECT_THAT(guardText(guard), HasSubstr("BROKEN"));
  EXPECT_THAT(guardMarkdown(guard), HasSubstr("| mje_deg.final.elbow is at most 2 | 2.5 | **broken** |"));
  EXPECT_THAT(guardJunit(guard), HasSubstr("failures=\"1\""));
  EXPECT_THAT(guardJunit(guard), HasSubstr("<failure message=\"found 2.5\"/>"));
}

TEST(Budget, RefusesLinesWithoutMeaning) {
  EXPECT_THROW(check("  - {value: mse}\n"), ConfigError);
  EXPECT_THAT(test::errorOf([] { check("  - verdict: [nothing-fuond]\n"); }), HasSubstr("nothing-found, data-fault"));
  EXPECT_THROW(check("  - {value: mse, lower: 2, upper: 1}\n"), ConfigError);
  EXPECT_THROW(check("  - {upper: 1}\n"), ConfigError);
  EXPECT_THAT(test::errorOf([] { check("  - {cause: payload, upper: -5}\n"); }), HasSubstr("found upper -5"));
  EXPECT_THROW(check("  - {value: mse, upper: 1, unknown: 2}\n"), ConfigError);
  EXPECT_THAT(test::errorOf([] { check("  - {value: mse, uper: 1}\n"); }), HasSubstr("uper"));
}

TEST(Budget, AHostilePatternTakesNoTime) {
  std::string pattern;
  for (int i = 0; i < 200; ++i) pattern += "*a";
  EXPECT_FALSE(holds(check("  - {parameter: '" + pattern + "b', upper: 1}\n")));
}

}  // namespace
}  // namespace simgap
