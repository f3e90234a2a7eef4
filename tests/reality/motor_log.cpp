#include "reality/motor_log.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "reality/measuring_chain.h"
#include "simgap/core/csv.h"

namespace simgap::reality {

MotorBenchLog simulateMotor(const MotorTruth& m, const MotorDesign& design) {
  const double step = design.step;
  std::mt19937_64 random(design.seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> normal;
  MotorBenchLog log;
  const auto rows = static_cast<int>(design.seconds * design.rate);
  const int inner = static_cast<int>(std::lround(1.0 / (design.rate * step)));
  // Seen from the rotor: the output's inertia and friction divided by the ratio, the rotor's torque times it.
  const double gain = m.ratio * m.efficiency;
  const double inertia = gain * m.inertia + m.gear_inertia / m.ratio;
  const double viscous = gain * m.viscous + m.gear_viscous / m.ratio;
  const double coulomb = gain * m.coulomb + m.gear_coulomb;
  for (int session = 0; session < design.sessions; ++session) {
    ColouredNoise current_noise(design.current_noise, design.noise_memory);
    ColouredNoise velocity_noise(design.velocity_noise, design.noise_memory);
    std::vector<double> voltages, currents;  // in steps of the integration
    const auto before = [&](const std::vector<double>& past, double rows_late) {
      const auto steps = static_cast<std::size_t>(std::lround(rows_late * inner));
      return past[past.size() - 1 - std::min(steps, past.size() - 1)];
    };
    double i = 0.0, w = 0.0, voltage = 0.0, load = 0.0, warmth = 0.0, angle = 0.0, wheel = 0.0, bent = 0.0;
    for (int k = 0; k < rows; ++k) {
      if (k % 317 == 0) voltage = design.voltage * uniform(random);
      if (k % 523 == 0) load = design.load * uniform(random);
      log.time.push_back(k / design.rate);
      voltages.push_back(voltage);
      currents.push_back(i);
      log.voltage.push_back(quantised(before(voltages, design.voltage_late), design.voltage_grain));
      log.load.push_back(load);
      log.current.push_back(
          quantised(before(currents, design.current_late) + m.current_offset + current_noise.next(normal(random)),
                    design.current_grain));
      log.velocity.push_back(quantised(w + velocity_noise.next(normal(random)), design.velocity_grain));
      log.session.push_back(session);
      for (int s = 0; s < inner; ++s) {
        if (s > 0) voltages.push_back(voltage), currents.push_back(i);
        // The winding by the trapezoidal rule, the rotor by a symplectic step with friction that can hold it.
        const double brushes = m.brush_drop * i / (std::abs(i) + 0.2);
        const double resistance = m.resistance * (1.0 + m.heating * warmth);
        const double rate = (voltage - m.emf * w - resistance * i - brushes) / m.inductance;
        warmth += step / m.heating_seconds * (i * i / 4.0 - warmth);
        i += rate * step / (1.0 + 0.5 * m.resistance * step / m.inductance);
        angle += w * step;
        // The wheel is pushed by whichever side of the play the rotor's tooth reaches, and stays where it is left.
        const bool meshes = std::abs(angle - wheel) >= 0.5 * m.play;
        if (meshes) wheel = angle - std::copysign(0.5 * m.play, angle - wheel);
        const double teeth = m.load_loss * std::abs(load);
        const double felt = meshes ? load + m.ripple * std::sin(m.ripple_turns * angle + 0.4) : 0.0;
        const double driving = gain * m.torque * i - felt - viscous * w;
        const double free = w + driving * step / inertia;
        const double hold = (meshes ? coulomb + teeth : 0.2 * coulomb) * step / inertia;
        if (m.bristle_travel > 0.0) {  // bristles that bend and slip: never held altogether
          const double side = w < 0.0 ? -1.0 : 1.0;
          bent = side + (bent - side) * std::exp(-std::abs(w) * step / m.bristle_travel);
          w = free - hold * bent;
          continue;
        }
        w = free > hold ? free - hold : free < -hold ? free + hold : 0.0;
      }
    }
  }
  return log;
}

std::string MotorBenchLog::csv(bool with_voltage, bool with_load, bool with_velocity) const {
  std::vector<std::string> header{"time_s", "current_A", "session"};
  if (with_voltage) header.emplace_back("voltage_V");
  if (with_load) header.emplace_back("load_torque_Nm");
  if (with_velocity) header.emplace_back("velocity_rad_s");
  CsvWriter writer(header);
  for (std::size_t k = 0; k < time.size(); ++k) {
    writer.add(time[k]).add(current[k]).add(static_cast<double>(session[k]));
    if (with_voltage) writer.add(voltage[k]);
    if (with_load) writer.add(load[k]);
    if (with_velocity) writer.add(velocity[k]);
    writer.endRow();
  }
  return writer.text();
}

}  // namespace simgap::reality
