#include "reality/pam_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "reality/measuring_chain.h"
#include "simgap/core/csv.h"

namespace simgap::reality {
namespace {

/// Volume of the braided cylinder at a length: a thread of fixed length wound a fixed number of times.
double volume(const PamTruth& m, double length) {
  const double thread = m.rest_length / std::cos(m.braid_angle);
  const double turns = thread * std::sin(m.braid_angle) / (std::numbers::pi * m.rest_diameter);
  const double girth2 = std::max(thread * thread - length * length, 0.0) / (turns * turns);
  return girth2 / (4.0 * std::numbers::pi) * length;
}

/// Virtual work: F dl = -p dV.
double braidForce(const PamTruth& m, double pressure, double contraction) {
  const double length = m.rest_length * (1.0 - contraction), h = 1e-6;
  return -pressure * (volume(m, length + h) - volume(m, length - h)) / (2.0 * h);
}

/// A tube of neo-Hookean rubber pushes back when it is shortened.
double wallForce(const PamTruth& m, double contraction) {
  const double stretch = 1.0 - contraction;
  return m.wall / 3.0 * (stretch - 1.0 / (stretch * stretch));
}

double muscleForce(const PamTruth& m, double pressure, double joint_contraction) {
  const auto excess = [&](double f) {
    const double stretch = m.tendon > 0.0 ? f / (m.tendon * (1.0 + m.tendon_hardening * f)) : 0.0;
    const double own = (joint_contraction + stretch) * (1.0 + m.ends * std::exp(-pressure / m.ends_pressure));
    return braidForce(m, std::max(pressure - m.bladder, 0.0), own) + wallForce(m, own) - f;
  };
  double low = 0.0, high = 1e4;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0.0 ? low : high) = middle;
  }
  return low;
}

}  // namespace

PamRecord recordPam(const PamTruth& m, const PamDesign& design) {
  constexpr double kBristle = 5e-4;  // contraction until the braid's friction has turned round
  std::mt19937_64 random(design.seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  ColouredNoise force_noise(design.force_noise, design.noise_memory);
  const auto through_hose = [&](double inside, double before, double now) {
    constexpr int kSteps = 40;
    const double dt = 1.0 / design.rate / kSteps;
    for (int step = 0; step < kSteps; ++step)
      inside += dt / m.hose_seconds * (before + (now - before) * (step + 0.5) / kSteps - inside);
    return inside;
  };
  const double late = design.pressure_late / design.rate;  // [s]
  PamRecord record;
  double humid = uniform(random) * 6.0;
  for (int s = 0; s < design.sessions; ++s) {
    const double period_e = 4.0 + 8.0 * uniform(random), period_p = 5.0 + 14.0 * uniform(random);
    const double phase_e = 6.28 * uniform(random), phase_p = 6.28 * uniform(random);
    const double middle_e = 0.06 + 0.06 * uniform(random), swing_e = 0.02 + 0.04 * uniform(random);
    const double middle_p = (2.2 + 1.2 * uniform(random)) * 1e5, swing_p = (1.0 + 0.9 * uniform(random)) * 1e5;
    std::vector<double> elastic;
    double last = 0.0, bristle = 0.0, settled = 0.0, inside = 0.0, p_before = 0.0;
    for (std::size_t k = 0; k < design.rows; ++k) {
      const double t = static_cast<double>(k) / design.rate;
      const double e = middle_e + swing_e * std::sin(6.2831853 * t / period_e + phase_e);
      const double p = middle_p + swing_p * std::sin(6.2831853 * t / period_p + phase_p);
      const double moved = k == 0 ? 0.0 : e - last;
      bristle += moved / kBristle - std::abs(moved) / kBristle * bristle;
      bristle = std::clamp(bristle, -1.0, 1.0);
      last = e;
      humid += 0.002 * normal(random) + 0.004;
      const double humidity = 50.0 + 20.0 * std::sin(humid);
      inside = k == 0 || m.hose_seconds <= 0.0 ? p : through_hose(inside, p_before, p);
      p_before = p;
      double f = muscleForce(m, inside, e) - m.braid_friction * inside * bristle;
      const double rate = moved * design.rate;
      f -= m.drag * std::copysign(std::pow(std::abs(rate) / 0.05, 0.85), rate);
      settled += k == 0 ? f : (f - settled) / (m.creep_seconds * design.rate);
      f += m.creep * (f - settled);
      elastic.push_back(f);
      for (std::size_t j = 1; m.creep_log > 0.0 && j <= k; ++j) {  // each change fades for itself (Boltzmann)
        const double since = static_cast<double>(k - j) / design.rate + 0.02;
        f += m.creep_log * (elastic[j] - elastic[j - 1]) * std::max(0.0, std::log(60.0 / since));
      }
      f *= 1.0 + m.breathing * std::sin(humid);
      record.time.push_back(t);
      const double seen = middle_p + swing_p * std::sin(6.2831853 * (t - late) / period_p + phase_p);
      record.pressure.push_back(
          quantised(seen + m.sensor_offset + design.pressure_noise * normal(random), design.pressure_grain));
      record.contraction.push_back(e + design.contraction_noise * normal(random));
      record.force.push_back(quantised(f + m.force_offset + force_noise.next(normal(random)), design.force_grain));
      record.humidity.push_back(humidity);
      record.session.push_back(s);
    }
  }
  return record;
}

std::string PamRecord::csv() const {
  CsvWriter writer({"time_s", "pressure_Pa", "contraction", "force_N", "humidity_percent", "session"});
  for (std::size_t k = 0; k < time.size(); ++k) {
    writer.add(time[k]).add(pressure[k]).add(contraction[k]).add(force[k]).add(humidity[k]);
    writer.add(static_cast<double>(session[k])).endRow();
  }
  return writer.text();
}

}  // namespace simgap::reality
