// How often a diagnosis of motions is right: forearms drawn and moved by the independent simulator, off from their
// models by what a static calibration leaves, with nothing or one cause hidden. The table of docs/diagnose-motions.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "simgap/core/random.h"
#include "simgap/core/yaml.h"
#include "simgap/diagnose/motions/motion_diagnosis.h"
#include "support/files.h"
#include "support/motions.h"
#include "support/statics.h"

namespace simgap {
namespace {

constexpr std::uint64_t kFirstForearm = 101, kForearms = 5;
constexpr double kWorthFinding = 0.05;  // of the held-out mean square

struct DrawnReality {
  reality::MovingArm truth;
  reality::MotionRigOptions rig;
};

/// A cause that the reality can have, by its own law; its magnitude is the first parameter of the catalogue's.
struct MotionTruth {
  const char* effect;  ///< "": nothing of the catalogue
  const char* target;
  double from, to;  ///< between which its magnitude is drawn
  void (*hide)(double magnitude, DrawnReality& drawn);
};

constexpr MotionTruth kMotionTruths[] = {
    {"", "", 0.0, 0.0, [](double, DrawnReality&) {}},
    {"command-latency", "", 0.01, 0.06, [](double x, DrawnReality& d) { d.truth.hidden.command_delay = x; }},
    {"joint-clock-offset", "", 0.02, 0.06, [](double x, DrawnReality& d) { d.rig.capture_delay = x; }},
    {"guide-friction", "", 0.05, 0.25, [](double x, DrawnReality& d) { d.truth.hidden.guide_loss = x; }},
    {"cord-relaxation", "", 0.15, 0.4, [](double x, DrawnReality& d) { d.truth.hidden.relaxing_share = x; }},
    {"current-limit", "", 1.0, 2.5, [](double x, DrawnReality& d) { d.truth.hidden.current_limit = x; }},
    {"supply-sag", "", 0.1, 0.5, [](double x, DrawnReality& d) { d.truth.hidden.supply_resistance = x; }},
    {"directional-efficiency", "", 0.5, 0.8, [](double x, DrawnReality& d) { d.truth.hidden.returned_efficiency = x; }},
    {"controller-gain", "muscle2", 0.3, 0.7,
     [](double x, DrawnReality& d) {
       d.truth.hidden.gains = {1.0, x};
     }},
    {"torque-constant", "muscle1", 0.7, 0.9,
     [](double x, DrawnReality& d) {
       d.truth.drives[0].torque_constant *= x;
       d.truth.drives[0].back_emf *= x;
     }},
    {"payload", "link1", 0.05, 0.3,
     [](double x, DrawnReality& d) {
       d.truth.arm.links[0].parts.push_back({0.005, 0.01, x, {0.0, 0.0, -0.2}, {0.0, 0.0, 1.0}});
     }},
    {"joint-viscous", "joint1", 2.5, 4.0, [](double x, DrawnReality& d) { d.truth.arm.links[0].viscous *= x; }},
    {"joint-coulomb", "joint1", 2.5, 4.0, [](double x, DrawnReality& d) { d.truth.arm.links[0].coulomb *= x; }},
    {"cord-damping", "", 3.0, 5.0,
     [](double x, DrawnReality& d) {
       for (reality::Muscle& muscle : d.truth.arm.muscles) muscle.damping *= x;
     }},
    // Of no catalogue: a drag that grows with the angle.
    {"drag", "", 0.5, 1.5,
     [](double x, DrawnReality& d) {
       d.truth.hidden.elbow_drag = [x](double angle, double speed) { return -x * angle * angle * speed; };
     }},
};

/// A forearm whose muscles pull at a lever that tension does not tip over: what falls to its stop tells little.
reality::MovingArm believedForearm() {
  reality::MovingArm forearm = test::movingForearm();
  for (reality::Muscle& muscle : forearm.arm.muscles) {
    for (reality::Attachment* end : {&muscle.from, &muscle.to}) end->point.y() *= 1.5;
  }
  return forearm;
}

/// Off from the believed forearm by what a static calibration and data sheets leave.
reality::MovingArm drawForearm(std::uint64_t seed) {
  const CounterRandom random(seed);
  std::uint32_t next = 0;
  const auto normal = [&] { return random.normalPair({next++, 0, 0, 93})[0]; };
  const auto scale = [&](double& value, double sd) { value *= std::exp(sd * normal()); };
  reality::MovingArm drawn = believedForearm();
  scale(drawn.arm.links[0].coulomb, 0.3);
  scale(drawn.arm.links[0].viscous, 0.3);
  for (reality::Muscle& muscle : drawn.arm.muscles) {
    for (Eigen::Vector3d* point : {&muscle.from.point, &muscle.to.point}) {
      for (double& x : *point) x += 1.5e-3 * normal();
    }
    muscle.kite_line += 2e-3 * normal();
    scale(muscle.stiffness, 0.03);
    scale(muscle.spindle_radius, 0.01);
    scale(muscle.damping, 0.3);
  }
  for (reality::DriveTruth& drive : drawn.drives) scale(drive.coulomb, 0.3);
  return drawn;
}

/// Sines and a step between tense and slack, fast and slow, then rest.
reality::Setpoints drawSetpoints(std::uint64_t draw) {
  const CounterRandom random(draw);
  const auto drawn = [&](std::uint32_t i, double from, double to) {
    return from + (to - from) * random.uniform({i, 0, 0, 94});
  };
  const double tension = drawn(0, 3.0, 4.4), swing = drawn(1, 0.4, 1.4), rate = drawn(2, 0.3, 1.8);
  const double step = drawn(3, 0.6, 1.6) * (draw % 2 ? 1.0 : -1.0), tenser = drawn(4, -0.6, 0.8);
  return [=](double time) {
    double co = tension, difference = 0.0;
    if (time >= 0.4) difference = swing * std::sin(2.0 * M_PI * rate * (time - 0.4));
    if (time >= 2.2) difference = step;
    if (time >= 3.2) co += tenser;
    return std::vector<double>{co + difference, co - difference};
  };
}

struct StudyCase {
  MotionDiagnosis said;
  double magnitude = 0.0;
};

StudyCase diagnoseDrawn(std::uint64_t seed, const MotionTruth& cause) {
  DrawnReality drawn{drawForearm(seed), {}};
  const CounterRandom random(seed);
  const auto kind = static_cast<std::uint32_t>(&cause - kMotionTruths);
  StudyCase one;
  one.magnitude = cause.from + (cause.to - cause.from) * random.uniform({kind, 0, 0, 96});
  cause.hide(one.magnitude, drawn);
  const ArmModel model = test::modelOf(believedForearm().arm, true);
  const MotionSet selecting = test::recordMotions(drawn.truth, model, drawSetpoints, 1000 * seed, 8, drawn.rig),
                  judging = test::recordMotions(drawn.truth, model, drawSetpoints, 1000 * seed + 500, 5, drawn.rig);
  one.said =
      diagnoseMotions(model, selecting, &judging,
                      MotionCalibrationConfig::read(YamlNode::load(test::sourceFile("configs/calibrate_motions.yaml"))),
                      {}, [](const std::string&, double) {});
  return one;
}

/// silent, right, group (the right one among others), unexplained, WRONG.
std::string judgedAs(const Diagnosis& said, const MotionTruth& truth) {
  const std::string label = std::string(truth.effect) + (*truth.target ? ":" : "") + truth.target;
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
    for (const CauseParameter& p : cause.parameters) {
      char value[96];
      std::snprintf(value, sizeof value, " %s=%.4g [%.4g, %.4g]", p.name.c_str(), p.value.value, p.value.lower95,
                    p.value.upper95);
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
    for (const MotionTruth& cause : kMotionTruths) {
      const StudyCase one = diagnoseDrawn(seed, cause);
      const Diagnosis& said = one.said.diagnosis;
      const std::string outcome = judgedAs(said, cause), effect = cause.effect;
      if (effect.empty()) noise = said.baseline.mse_heldout;
      const double worth = 1.0 - noise / said.baseline.mse_heldout;
      std::printf("%lu %s:%s %.4g worth %.3f: %s; heldout %.3f -> %.3f;%s; %ld rollouts\n", seed, cause.effect,
                  cause.target, one.magnitude, worth, outcome.c_str(), said.baseline.mse_heldout,
                  said.extended.mse_heldout, causesOf(said).c_str(), one.said.rollouts);
      std::fflush(stdout);
      ++(effect.empty() ? nothing : effect == "drag" ? outside : worth >= kWorthFinding ? hidden : nothing)[outcome];
      if (outcome != "right") continue;
      const Interval& value = said.causes.front().parameters.front().value;
      ++intervals;
      holding += value.lower95 <= one.magnitude && one.magnitude <= value.upper95;
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
  EXPECT_EQ(outside["unexplained"], of(outside));
  EXPECT_GE(holding, 0.9 * intervals);
}

}  // namespace
}  // namespace simgap
