// How often `diagnose` names what was hidden in the log of a robot (docs/studies/diagnose-robots.md).
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "diagnose/robots/robot_cases.h"

namespace simgap {
namespace {

std::string said(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const Cause& cause : d.causes) {
    std::string name = fmt::format("{} ({:.0f} %)", test::labelOf(cause), 100.0 * cause.gain_heldout.value);
    for (const std::string& other : cause.ambiguous_with) name += " or " + other;
    names.push_back(name);
  }
  for (const Candidate& c : d.candidates) names.push_back(fmt::format("[{} {}: {}]", c.effect, c.target, c.reason));
  return names.empty() ? "nothing" : fmt::format("{}", fmt::join(names, ", "));
}

int numberFrom(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text == nullptr ? otherwise : std::atoi(text);
}

/// SIMGAP_CLEAN and SIMGAP_HIDDEN: how many; SIMGAP_FIRST: the first seed; SIMGAP_FROM: the first of the hidden;
/// SIMGAP_CAUSE: what is hidden in all of them instead of each in turn.
TEST(SlowRobotDiagnosisStudy, DrawnRobots) {
  const int clean = numberFrom("SIMGAP_CLEAN", 20), hidden = numberFrom("SIMGAP_HIDDEN", 48);
  const int first = numberFrom("SIMGAP_FIRST", 1001);
  const reality::RobotRigOptions rig = test::shortRig(40.0);
  int alarms = 0;
  for (int k = 0; k < clean; ++k) {
    const auto seed = static_cast<std::uint64_t>(first + k);
    const test::RobotCase drawn = test::drawCase(seed, 2 + k % 6, rig);
    const Diagnosis d = test::diagnoseCase(drawn, drawn.robot, rig, 3 * seed + 1).diagnosis;
    alarms += d.causes.empty() ? 0 : 1;
    fmt::print("clean {} joints {}: {} {}\n", seed, 2 + k % 6, toString(d.verdict), said(d));
    std::fflush(stdout);
  }
  std::map<std::string, int> answers;
  const std::vector<std::string>& names = reality::robotFlawNames();
  const int from = numberFrom("SIMGAP_FROM", 0);
  const char* same = std::getenv("SIMGAP_CAUSE");
  for (int k = from; k < from + hidden; ++k) {
    const auto seed = static_cast<std::uint64_t>(first + 100 + k);
    const int joints = 2 + k % 6;
    const std::string cause = same != nullptr ? same : names[static_cast<std::size_t>(k) % names.size()];
    const test::RobotCase drawn = test::drawCase(seed, joints, rig);
    const reality::RobotFlaw flaw = reality::hideFlaw(drawn.robot, cause, test::shortRig(10.0), 3 * seed + 2, seed);
    const Diagnosis d = test::diagnoseCase(drawn, flaw.robot, rig, 3 * seed + 1).diagnosis;
    const std::string answer = test::answerFor(d, flaw.label());
    ++answers[answer];
    fmt::print("{} {} joints {}: {} -> {} {}\n", answer, seed, joints, flaw.label(), toString(d.verdict), said(d));
    std::fflush(stdout);
  }
  fmt::print("clean: {} of {} with a cause; hidden: {} right, {} in a group, {} missed, {} wrong of {}\n", alarms,
             clean, answers["right"], answers["grouped"], answers["missed"], answers["wrong"], hidden);
  EXPECT_LE(alarms, 0.05 * clean);
  EXPECT_GE(answers["right"] + answers["grouped"], 0.9 * hidden);
  EXPECT_EQ(answers["wrong"], 0);
}

}  // namespace
}  // namespace simgap
