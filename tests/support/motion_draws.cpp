#include "support/motion_draws.h"

#include <algorithm>

namespace simgap::test {
namespace {

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
       d.truth.hidden.gains.assign(d.truth.drives.size(), 1.0);
       d.truth.hidden.gains[1] = x;
     }},
    {"torque-constant", "muscle1", 0.7, 0.9,
     [](double x, DrawnReality& d) {
       d.truth.drives[0].torque_constant *= x;
       d.truth.drives[0].back_emf *= x;
     }},
    {"payload", "link", 0.05, 0.3,
     [](double x, DrawnReality& d) {
       d.truth.arm.links.back().parts.push_back({0.005, 0.01, x, {0.0, 0.0, -0.2}, {0.0, 0.0, 1.0}});
     }},
    {"joint-viscous", "joint", 2.5, 4.0, [](double x, DrawnReality& d) { d.truth.arm.links.back().viscous *= x; }},
    {"joint-coulomb", "joint", 2.5, 4.0, [](double x, DrawnReality& d) { d.truth.arm.links.back().coulomb *= x; }},
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

/// Of all cords, geometric mean [N s/m].
double dampingOf(const reality::Arm& arm) {
  double sum = 0.0;
  for (const reality::Muscle& muscle : arm.muscles) sum += std::log(muscle.damping);
  return std::exp(sum / static_cast<double>(arm.muscles.size()));
}

reality::MovingArm believedArm(MotionArm arm) {
  reality::MovingArm believed;
  if (arm == MotionArm::kReferenceArm) {
    believed.arm = reality::referenceArm();
    believed.drives.resize(believed.arm.muscles.size());
    return believed;
  }
  believed = movingForearm();
  for (reality::Muscle& muscle : believed.arm.muscles) {
    for (reality::Attachment* end : {&muscle.from, &muscle.to}) end->point.y() *= 1.5;
  }
  return believed;
}

}  // namespace

std::span<const MotionTruth> motionTruths() { return kMotionTruths; }

const MotionTruth* findMotionTruth(std::string_view effect) {
  const auto* found = std::ranges::find_if(kMotionTruths, [&](const MotionTruth& one) { return one.effect == effect; });
  return found == std::end(kMotionTruths) ? nullptr : found;
}

void deviate(reality::Arm& arm, Deviations& deviations) {
  for (reality::Link& link : arm.links) {
    deviations.scale(link.coulomb, 0.3);
    deviations.scale(link.viscous, 0.3);
  }
  for (reality::Muscle& muscle : arm.muscles) {
    for (Eigen::Vector3d* point : {&muscle.from.point, &muscle.to.point}) {
      for (double& x : *point) x += 1.5e-3 * deviations.normal();
    }
    muscle.kite_line += 2e-3 * deviations.normal();
    deviations.scale(muscle.stiffness, 0.03);
    deviations.scale(muscle.spindle_radius, 0.01);
    deviations.scale(muscle.damping, 0.3);
  }
}

reality::Setpoints opposedSwings(std::uint64_t draw, const SwingSizes& sizes) {
  const CounterRandom random(draw);
  const auto drawn = [&](std::uint32_t i, double from, double to) {
    return from + (to - from) * random.uniform({i, 0, 0, sizes.stream});
  };
  const double tension = drawn(0, 3.0, 4.4), swing = drawn(1, sizes.swing_from, sizes.swing_to);
  const double rate = drawn(2, 0.3, 1.8), tenser = drawn(4, -0.6, 0.8);
  const double step = drawn(3, sizes.step_from, sizes.step_to) * (draw % 2 ? 1.0 : -1.0);
  return [=](double time) {
    double co = tension, difference = 0.0;
    if (time >= 0.4) difference = swing * std::sin(2.0 * M_PI * rate * (time - 0.4));
    if (time >= 2.2) difference = step;
    if (time >= 3.2) co += tenser;
    return std::vector<double>{co + difference, co - difference};
  };
}

reality::Setpoints swingsBetweenRests(const reality::Arm& arm, std::uint64_t draw, const RestSwings& swings) {
  const auto a = reality::randomShafts(arm, 3 * draw), b = reality::randomShafts(arm, 3 * draw + 1),
             c = reality::randomShafts(arm, 3 * draw + 2);
  const CounterRandom random(draw);
  const double rate = swings.slowest + swings.rates * random.uniform({0, 0, 0, swings.stream});
  return [=](double time) {
    if (time < 0.4) return a;
    if (time >= swings.until) return c;
    std::vector<double> now = b;
    for (std::uint32_t m = 0; m < now.size(); ++m) {
      const double phase = 2.0 * M_PI * random.uniform({1, m, 0, swings.stream});
      now[m] += swings.size * std::sin(2.0 * M_PI * rate * time + phase);
    }
    return now;
  };
}

HiddenMotionCase drawHidden(MotionArm arm, std::uint64_t seed, const MotionTruth& truth) {
  HiddenMotionCase drawn{believedArm(arm), {}, 0.0, truth.target};
  drawn.drawn.truth = drawn.believed;
  Deviations deviations(seed, 93);
  deviate(drawn.drawn.truth.arm, deviations);
  for (reality::DriveTruth& drive : drawn.drawn.truth.drives) deviations.scale(drive.coulomb, 0.3);
  const auto kind = static_cast<std::uint32_t>(&truth - kMotionTruths);
  drawn.magnitude = truth.from + (truth.to - truth.from) * CounterRandom(seed).uniform({kind, 0, 0, 96});
  drawn.drawn.truth.hidden.guide_creep = 3e-4 * std::pow(10.0, CounterRandom(seed).uniform({kind, 0, 0, 98}));
  truth.hide(drawn.magnitude, drawn.drawn);
  const reality::Link &is = drawn.drawn.truth.arm.links.back(), &was = drawn.believed.arm.links.back();
  const std::string effect = truth.effect;  // what is named of ordinary parameters is against what is believed
  if (effect == "joint-viscous") drawn.magnitude = is.viscous / was.viscous;
  if (effect == "joint-coulomb") drawn.magnitude = is.coulomb / was.coulomb;
  if (effect == "cord-damping") drawn.magnitude = dampingOf(drawn.drawn.truth.arm) / dampingOf(drawn.believed.arm);
  const int last = static_cast<int>(drawn.believed.arm.links.size()) - 1;
  if (drawn.target == "link") drawn.target = reality::linkName(last);
  if (drawn.target == "joint") drawn.target = reality::jointName(last);
  return drawn;
}

reality::Setpoints drawSetpoints(MotionArm arm, std::uint64_t draw) {
  if (arm == MotionArm::kForearm) return opposedSwings(draw, {0.4, 1.4, 0.6, 1.6, 94});
  return swingsBetweenRests(reality::referenceArm(), draw, {0.4, 1.4, 0.5, 2.6, 97});
}

}  // namespace simgap::test
