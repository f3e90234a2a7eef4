#include "reality/spring_rig.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "simgap/core/csv.h"

namespace simgap::reality {
namespace {

using Curve = std::vector<std::pair<double, double>>;

double readOff(const Curve& curve, double x) {
  if (curve.empty()) return 150.0 * x;
  std::size_t i = 1;
  while (i + 1 < curve.size() && x > curve[i].first) ++i;
  const auto& [x0, f0] = curve[i - 1];
  const auto& [x1, f1] = curve[i];
  return f0 + (f1 - f0) * (x - x0) / (x1 - x0);
}

/// The parts of a spring that remember.
class Memory {
 public:
  Memory(const SpringTruth& truth, std::mt19937_64& random) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    constexpr int kSliders = 60, kMaxwell = 15;
    for (int k = 0; k < kSliders; ++k)
      slip_.push_back(truth.slip * (1.0 + truth.slip_spread * (2.0 * uniform(random) - 1.0)));
    double whole = 0.0;
    for (const double s : slip_) whole += s;
    slider_stiffness_ = truth.friction / whole;
    for (int k = 0; k < kMaxwell; ++k) {
      const double place = (k + 0.5) / kMaxwell - 0.5;
      tau_.push_back(truth.creep_seconds * std::pow(10.0, truth.creep_decades * place));
    }
    element_stiffness_ = truth.creep_stiffness / kMaxwell;
    dashpot_.assign(kMaxwell, 0.0);
    constexpr int kChains = 400;
    for (int k = 0; truth.breaking > 0.0 && k < kChains; ++k)
      chains_.push_back({truth.breaking / kChains, truth.breaking_reach * uniform(random), true});
    slider_.assign(kSliders, 0.0);
  }
  /// Force of all parts after the end has moved to x over dt: each dashpot flows, each slider is dragged along.
  double moveTo(double x, double dt) {
    double force = 0.0;
    constexpr int kSteps = 8;
    for (std::size_t k = 0; k < dashpot_.size(); ++k) {
      for (int s = 0; s < kSteps; ++s) dashpot_[k] += dt / kSteps / (tau_[k] + 0.5 * dt / kSteps) * (x - dashpot_[k]);
      force += element_stiffness_ * (x - dashpot_[k]);
    }
    for (std::size_t k = 0; k < slider_.size(); ++k) {
      if (x - slider_[k] > slip_[k]) slider_[k] = x - slip_[k];
      if (slider_[k] - x > slip_[k]) slider_[k] = x + slip_[k];
      force += slider_stiffness_ * (x - slider_[k]);
    }
    return force;
  }
  /// Force of the chains that no stretch up to now has broken.
  double ofChains(double x) {
    double force = 0.0;
    for (Chain& chain : chains_) {
      chain.whole = chain.whole && std::abs(x) < chain.longest;
      if (chain.whole) force += chain.stiffness * x;
    }
    return force;
  }
  void settleAt(double x) {
    std::ranges::fill(dashpot_, x);
    std::ranges::fill(slider_, x);
  }

 private:
  struct Chain {
    double stiffness, longest;
    bool whole;
  };
  std::vector<Chain> chains_;
  std::vector<double> slip_, slider_, tau_, dashpot_;
  double slider_stiffness_ = 0.0, element_stiffness_ = 0.0;
};

/// Where the rig is at every tick: rests first, then ramps to levels drawn at random, each held, and cycles between.
std::vector<double> motionOf(const SpringDesign& design, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double range = design.high - design.low, dt = 1.0 / design.rate;
  const double home = std::clamp(0.0, design.low, design.high);
  std::vector<double> x;
  const auto hold = [&](double seconds) {
    for (double t = 0.0; t < seconds; t += dt) x.push_back(x.empty() ? home : x.back());
  };
  hold(1.0);
  while (static_cast<double>(x.size()) * dt < design.seconds) {
    const double to = design.low + range * uniform(random), from = x.back();
    const double speed = range * std::pow(10.0, -1.5 + 1.5 * uniform(random));
    const double seconds = std::max(std::abs(to - from) / speed, 0.2);
    for (double t = dt; t < seconds; t += dt) {
      const double s = t / seconds;
      x.push_back(from + (to - from) * s * s * (3.0 - 2.0 * s));
    }
    if (uniform(random) < 0.6) hold(0.5 + 3.0 * uniform(random));
    if (uniform(random) < 0.4) {
      const double middle = x.back(), period = 0.6 + 3.0 * uniform(random);
      const double reach = std::min({0.4 * range * uniform(random), middle - design.low, design.high - middle});
      for (double t = dt; t < 2.0 * period; t += dt)
        x.push_back(middle + reach * std::sin(2.0 * 3.14159265 * t / period));
    }
  }
  x.resize(static_cast<std::size_t>(design.seconds * design.rate));
  return x;
}

}  // namespace

SpringRecord recordSpring(const SpringTruth& truth, const SpringDesign& design) {
  std::mt19937_64 random(design.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Memory memory(truth, random);
  SpringRecord record;
  double humid = 6.0 * uniform(random);
  for (int s = 0; s < design.sessions; ++s) {
    SpringDesign session = design;
    if (design.growing) session.low *= (s + 1.0) / design.sessions, session.high *= (s + 1.0) / design.sessions;
    const std::vector<double> x = motionOf(session, random);
    memory.settleAt(x[0]);
    double t = 0.0, wire = std::max(x[0], truth.pulls_only ? truth.slack_below : x[0]);
    for (const double end : x) {
      const double dt = (0.9 + 0.2 * uniform(random)) / design.rate;
      // A wire follows its end only while it is taut.
      const double now = truth.pulls_only ? std::max(end, truth.slack_below) : end;
      double force = readOff(truth.curve, now) + truth.damping * (now - wire) / dt +
                     truth.sliding * std::asinh((now - wire) / dt / 1e-3) + memory.moveTo(now, dt) +
                     memory.ofChains(now);
      if (truth.pulls_only)
        force = end > truth.slack_below ? std::max(0.0, force - readOff(truth.curve, truth.slack_below)) : 0.0;
      wire = now;
      t += dt;
      humid += 0.002 * normal(random) + 0.004;
      force *= 1.0 + truth.sweating * std::sin(humid);
      force += truth.force_offset + design.force_noise * normal(random);
      record.time.push_back(t);
      record.deflection.push_back(design.encoder_step * std::round(end / design.encoder_step));
      record.force.push_back(std::clamp(force, -design.force_limit, design.force_limit));
      record.humidity.push_back(50.0 + 20.0 * std::sin(humid));
      record.session.push_back(s);
    }
  }
  const auto rows = static_cast<double>(record.time.size());
  for (int k = 0; k < design.spikes; ++k) {
    record.deflection[static_cast<std::size_t>(rows * uniform(random))] += 0.3 * (design.high - design.low);
    record.force[static_cast<std::size_t>(rows * uniform(random))] -= 8.0;
  }
  return record;
}

std::string SpringRecord::csv() const {
  CsvWriter writer({"time_s", "deflection_m", "force_N", "humidity_percent", "session"});
  for (std::size_t k = 0; k < time.size(); ++k) {
    writer.add(time[k]).add(deflection[k]).add(force[k]).add(humidity[k]);
    writer.add(static_cast<double>(session[k])).endRow();
  }
  return writer.text();
}

Curve rubberCurve(double length) {
  // Stress over the initial slope, at steps of 10 % of expansion.
  constexpr double kForce[] = {0.0, 0.091, 0.169, 0.236, 0.295, 0.348, 0.396, 0.440, 0.481, 0.520, 0.557};
  Curve curve;
  for (int k = 10; k > 0; --k) curve.emplace_back(-0.1 * k * length, -150.0 * length * kForce[k]);
  for (int k = 0; k <= 10; ++k) curve.emplace_back(0.1 * k * length, 150.0 * length * kForce[k]);
  return curve;
}

Curve ropeCurve(double length) {
  constexpr double kForce[] = {0.0, 0.05, 0.11, 0.19, 0.29, 0.42, 0.58, 0.78, 1.02, 1.30, 1.62};
  Curve curve;
  for (int k = 10; k > 0; --k) curve.emplace_back(-0.1 * k * length, -150.0 * length * kForce[k]);
  for (int k = 0; k <= 10; ++k) curve.emplace_back(0.1 * k * length, 150.0 * length * kForce[k]);
  return curve;
}

}  // namespace simgap::reality
