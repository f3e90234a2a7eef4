// Which causes are asked for follows from what the effects say they need.
#include "diagnose/logs/testable.h"

#include <gtest/gtest.h>

#include "diagnose/logs/held_out.h"
#include "diagnose/logs/log_causes.h"
#include "prepared_logs.h"

namespace simgap::test {
namespace {

struct Asked {
  std::vector<std::string> effects;
  std::vector<NotTestable> others;
  std::string reason(const std::string& effect) const {
    const auto found = std::ranges::find(others, effect, &NotTestable::effect);
    return found == others.end() ? "" : found->reason;
  }
  bool has(const std::string& effect) const { return std::ranges::find(effects, effect) != effects.end(); }
};

Asked ask(const ActuatorModel& subject, const PreparedLog& log, const LogDiagnosisOptions& options = {}) {
  Diagnosis diagnosis;
  Asked asked;
  for (const Hypothesis& h : namedHypotheses(subject, log.data, options, diagnosis)) {
    asked.effects.emplace_back(h.effect->name);
  }
  asked.others = diagnosis.not_testable;
  return asked;
}

TEST(Testable, NoTermTwice) {
  const PreparedLog log = preparedLog(smallRig(1500));
  const Asked of_coulomb = ask(subjectOf("coulomb"), log), of_variant_b = ask(subjectOf("variant-b"), log);
  EXPECT_TRUE(of_coulomb.has("load-dependence"));
  EXPECT_TRUE(of_coulomb.has("stribeck"));
  EXPECT_NE(of_coulomb.reason("coulomb-offset").find("part of the law coulomb"), std::string::npos);
  EXPECT_NE(of_coulomb.reason("stiction-ageing").find("needs a law with a Stribeck term"), std::string::npos);
  for (const char* effect : {"coulomb-offset", "static-offset", "stribeck", "load-dependence"}) {
    EXPECT_NE(of_variant_b.reason(effect).find("part of the law variant-b"), std::string::npos) << effect;
  }
}

TEST(Testable, WhatTheLogLacks) {
  PreparedLog log = preparedLog(smallRig(1500));
  log.data.rows.load.setZero();
  log.data.rows.top_load = 0.0;
  log.data.rows.joint_angle.resize(0);
  log.data.rows.rest.setZero();
  const Asked asked = ask(subjectOf("stribeck"), log);
  EXPECT_EQ(asked.reason("load-dependence"), "needs a load that changes");
  // Nothing grows faster than a term that the law has not.
  EXPECT_EQ(asked.reason("load-nonlinearity"), "part of the law stribeck, or without meaning in it");
  EXPECT_EQ(asked.reason("bend-friction"), "needs joint_position_rad");
  EXPECT_EQ(asked.reason("stiction-ageing"), "needs rests of 1 s and longer");
}

TEST(Testable, NoQuietCopyOfANoisyLoad) {
  PreparedLog log = preparedLog(smallRig(1500));
  EXPECT_TRUE(ask(subjectOf("stribeck"), log).has("inertia"));
  log.data.load_noise = 0.05;
  const Asked asked = ask(subjectOf("stribeck"), log);
  for (const char* effect : {"inertia", "joint-gravity", "joint-spring"}) {
    EXPECT_EQ(asked.reason(effect), "the load is so noisy that a quieter copy of it would pass for this") << effect;
  }
  EXPECT_TRUE(asked.has("bend-friction"));
}

// A pendulum's load is worked out from its weight: what no sensor reads has no sensor's offset.
TEST(Testable, ASensorThatIsNotThereHasNoOffset) {
  PreparedLog log = preparedLog(smallRig(1500));
  EXPECT_TRUE(ask(subjectOf("classic"), log).has("torque-bias"));
  log.data.rows.load_measured = false;
  EXPECT_EQ(ask(subjectOf("classic"), log).reason("torque-bias"), "needs a load that a sensor measures");
}

TEST(Testable, AnOffsetOfTheFitTakesTheBiasAway) {
  PreparedLog log = preparedLog(smallRig(1500));
  log.data.offset = false;
  EXPECT_TRUE(ask(subjectOf("classic"), log).has("current-bias"));
  log.data.offset = true;
  EXPECT_FALSE(ask(subjectOf("classic"), log).has("current-bias"));
}

TEST(Testable, OnlyWhatIsWanted) {
  LogDiagnosisOptions options;
  options.effects = {"inertia"};
  const Asked asked = ask(subjectOf("classic"), preparedLog(smallRig(1500)), options);
  EXPECT_EQ(asked.effects, std::vector<std::string>{"inertia"});
  EXPECT_TRUE(asked.others.empty());
}

TEST(Testable, AGearboxHasItsOwnWordsForSome) {
  EXPECT_TRUE(appliesTo(actuator_effects::find("inertia"), ActuatorKind::kGearbox));
  EXPECT_TRUE(appliesTo(actuator_effects::find("backlash"), ActuatorKind::kGearbox));
  EXPECT_TRUE(appliesTo(actuator_effects::find("presliding-hysteresis"), ActuatorKind::kGearbox));
  EXPECT_FALSE(appliesTo(actuator_effects::find("backdrive-asymmetry"), ActuatorKind::kGearbox));
  EXPECT_FALSE(appliesTo(actuator_effects::find("load-dependent-efficiency"), ActuatorKind::kFriction));
}

// Ageing of which a drive of 3 N m showed 33 N m and more was listed as what would have been found.
TEST(Testable, ACauseThatWouldHaveToExceedTheEffortIsNot) {
  const PreparedLog log = preparedLog(smallRig(3000));
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("classic"), log.data, splitLog(log, options).training, options);
  const std::vector<Trial> trials =
      search.tryAll(search.fit({}, nullptr), {{&actuator_effects::find("coulomb-offset"), {}, {}}});
  Diagnosis usual, blind;
  addDetectable(search, trials, options.least_gain, 1000.0, usual);
  EXPECT_TRUE(usual.not_testable.empty());
  ASSERT_EQ(usual.detectable.size(), 1u);
  EXPECT_EQ(usual.detectable[0].effect, "coulomb-offset");
  addDetectable(search, trials, options.least_gain, 1e12, blind);  // of which a hundredth is no small part
  EXPECT_TRUE(blind.detectable.empty());
  ASSERT_EQ(blind.not_testable.size(), 1u);
  EXPECT_TRUE(blind.not_testable[0].reason.ends_with("more than the effort itself")) << blind.not_testable[0].reason;
}

}  // namespace
}  // namespace simgap::test
