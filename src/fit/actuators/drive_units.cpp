#include "drive_units.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "simgap/core/rotation.h"

namespace simgap {
namespace {

constexpr double kPerDegree = 1.0 / kDegree, kPerRpm = 30.0 / std::numbers::pi;

bool isAbout(double value, double expected) {
  constexpr double kAbout = 0.1;
  return std::abs(value / expected - 1.0) < kAbout;
}

}  // namespace

std::string strangeConstants(const Estimate& emf, const Estimate& torque) {
  constexpr double kApart = 3.0;  // conventions of three phases come to a factor of 2
  constexpr double kKnown = 0.2;  // relative standard deviation
  for (const Estimate* e : {&emf, &torque}) {
    if (!e->fixed && !(e->sd < kKnown * e->value)) return "";
  }
  const double factor = torque.value / emf.value;
  if (!(std::max(factor, 1.0 / factor) > kApart)) return "";
  const char* const slip = isAbout(factor, kPerDegree) ? "velocity_rad_s looks like degrees per second"
                           : isAbout(factor, kPerRpm)  ? "velocity_rad_s looks like rpm"
                           : isAbout(factor, 1e3)      ? "load_torque_Nm looks like mNm"
                           : isAbout(factor, 1e-3)     ? "current_A looks like mA, or voltage_V like mV"
                                                       : "are all columns in the units that they say?";
  return fmt::format("K_T is {:.3g} times K_E, in SI units a motor's are about one: {}", factor, slip);
}

std::string strangeVelocity(const MotorLog& log, const Motor& motor, double ratio) {
  constexpr double kApart = 2.0;
  double product = 0.0, square = 0.0;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    const double expected = (log.voltage[i] - motor.resistance * log.current[i]) / motor.back_emf_constant;
    product += expected * log.velocity[i];
    square += expected * expected;
  }
  const double factor = product / square;
  if (factor > 1.0 / kApart && factor < kApart) return "";
  const char* const slip = isAbout(factor, kPerDegree)    ? ": it looks like degrees per second"
                           : isAbout(factor, kPerRpm)     ? ": it looks like rpm"
                           : isAbout(factor, 1.0 / ratio) ? ": it looks like the output's, expected the motor's"
                                                          : ": is it the motor's, and this its model?";
  return fmt::format("velocity_rad_s is {:.3g} times what voltage and current give with the motor's R and K_E{}",
                     factor, slip);
}

}  // namespace simgap
