// Effects that act while an arm moves: the model with one moves as the independent simulator does with that cause in
// its own equations; neutral ones change nothing; files keep them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/motion_error.h"
#include "support/motions.h"
#include "support/statics.h"

namespace simgap {
namespace {

reality::Setpoints forearmMovement(std::uint64_t) { return test::forearmSetpoints(1); }

/// Joint error of a model on a motion [deg].
double missedBy(const ArmModel& model, const MotionSet& set) {
  MotionOptions options;
  options.rollout.step = 0.001;
  const auto played = playAll(model, set.motions, options);
  return toDegrees(motionRms(set.motions, played, model.poseLayout()).joints.front());
}

struct KnownCause {
  const char* effect;
  const char* target;
  EffectParameters p;
  void (*hide)(reality::MovingArm& arm, reality::MotionRigOptions& rig);
};

class MotionEffects : public testing::TestWithParam<KnownCause> {};

TEST_P(MotionEffects, MoveTheArmAsTheyMoveTheIndependentOne) {
  reality::MovingArm truth = test::movingForearm();
  reality::MotionRigOptions rig;
  rig.capture_sd = rig.shaft_sd = rig.current_sd = 0.0;
  GetParam().hide(truth, rig);
  ArmModel model = test::modelOf(test::movingForearm().arm, true);
  const MotionSet set = test::recordMotions(truth, model, forearmMovement, 1, 1, rig);
  const double without = missedBy(model, set);
  model.extensions.push_back(makeExtension(*findArmEffect(GetParam().effect), GetParam().target, GetParam().p));
  const double with = missedBy(model, set);
  EXPECT_GT(without, 0.2);
  EXPECT_LT(with, 0.15 * without) << "from " << without << " deg";
}

const KnownCause kKnown[] = {
    {"command-latency", "", {0.04}, [](auto& arm, auto&) { arm.hidden.command_delay = 0.04; }},
    {"joint-clock-offset", "", {0.05}, [](auto&, auto& rig) { rig.capture_delay = 0.05; }},
    {"guide-friction", "", {0.15, 1e-3}, [](auto& arm, auto&) { arm.hidden.guide_loss = 0.15; }},
    {"cord-relaxation",
     "",
     {0.3, 0.5},
     [](auto& arm, auto&) {
       arm.hidden.relaxing_share = 0.3;
       arm.hidden.relaxing_time = 0.5;
     }},
    {"current-limit", "", {1.5}, [](auto& arm, auto&) { arm.hidden.current_limit = 1.5; }},
    {"controller-gain",
     "muscle2",
     {0.4},
     [](auto& arm, auto&) {
       arm.hidden.gains = {1.0, 0.4};
     }},
    {"supply-sag", "", {0.5, 0.005}, [](auto& arm, auto&) { arm.hidden.supply_resistance = 0.5; }},
    {"torque-constant",
     "muscle1",
     {0.7},
     [](auto& arm, auto&) {
       arm.drives[0].torque_constant *= 0.7;
       arm.drives[0].back_emf *= 0.7;
     }},
    {"inertia-error", "link1", {3.0}, [](auto& arm, auto&) {
       // Two discs far out and a hole at the centre: as much mass at the same centre.
       const auto rod = arm.arm.links[0].parts[0];  // a copy: the list grows
       const double across = rod.mass * (3.0 * rod.radius * rod.radius + rod.length * rod.length) / 12.0;
       const double mass = across / (0.2 * 0.2);  // 2 m d^2 = 2 I
       for (const double side : {-0.2, 0.2}) {
         arm.arm.links[0].parts.push_back({1e-3, 1e-3, mass, rod.position + side * rod.axis, rod.axis});
       }
       arm.arm.links[0].parts.push_back({1e-3, 1e-3, -2.0 * mass, rod.position, rod.axis});
     }}};

std::string knownName(const testing::TestParamInfo<KnownCause>& info) {
  std::string name = info.param.effect;
  std::ranges::replace(name, '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Known, MotionEffects, testing::ValuesIn(kKnown), knownName);

TEST(MotionEffectContract, NeutralChangesNothingAndFilesKeepThem) {
  const ArmModel plain = test::modelOf(test::movingForearm().arm, true);
  reality::MotionRigOptions rig;
  rig.duration = 1.0;
  const MotionSet set = test::recordMotions(test::trueForearm(), plain, forearmMovement, 1, 1, rig);
  const double before = missedBy(plain, set);
  int effects = 0;
  for (const ArmEffect* effect : arm_effects::all()) {
    if (!effect->needs_motion) continue;
    ++effects;
    const std::string target = effectTargets(*effect, plain).back();
    ArmModel neutral = plain;
    EffectParameters p = effect->starts.front();
    p[0] = effect->parameters[0].neutral;
    neutral.extensions = {makeExtension(*effect, target, p)};
    EXPECT_NEAR(missedBy(neutral, set), before, 1e-6) << effect->name;
    neutral.extensions = {makeExtension(*effect, target, effect->starts.front())};
    const ArmModel again = readArm(YamlNode::parse(writeArm(neutral), "arm.yaml"));
    EXPECT_EQ(writeArm(again), writeArm(neutral));
    EXPECT_NE(missedBy(again, set), before) << effect->name;
  }
  EXPECT_GE(effects, 10);
}

}  // namespace
}  // namespace simgap
