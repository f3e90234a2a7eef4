/// \file
/// Torque of a joint that two pneumatic muscles and a motor turn (002 section III), for simulators and controllers: one
/// header besides pam.h, no allocation, under a microsecond a call (some microseconds where a stiffness is asked for).
///
///     eps_f = eps_f0 + r0 theta / L0,   eps_e = eps_e0 - r0 theta / L0
///     tau_muscles = (f_f - f_e) r0                             002 eq. 10
///     tau         = tau_muscles + tau_motor                    002 eq. 11
///     p           = f / g(eps + f / k)                         002 eq. 17
///     tau_motor   = tau - tau_muscles                          002 eq. 18
///
/// The flexor (f, the paper's PAM1) turns the joint towards larger angles and contracts as it gets there.
///
///     simgap::TorqueSplit split(joint, {.highest_pressure = 6e5, .motor_limit = 9.0, .crossover = 2.0});
///     simgap::TorqueShares shares = split.update(torque, angle, load_cells, 0.002);    // every 2 ms
///     // shares.flexor_pressure and shares.extensor_pressure to the valves, shares.motor to the motor
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simgap/model/actuator/pam.h"

namespace simgap {

/// A pressure, and the force that it gives at rest.
struct MuscleCommand {
  double pressure = 0.0;  ///< [Pa]
  double force = 0.0;     ///< [N]
};

/// Two muscles over one pulley. Each one's range ends where it is slack (`highest = slack()`), so that outside of it
/// the force is 0.
struct AntagonistJoint {
  Pam flexor, extensor;
  double radius = 0.0;         ///< r0 of the pulley [m]
  double length = 1.0;         ///< L0 of the muscles [m]
  double rest_flexor = 0.0;    ///< eps_f0: contraction at angle 0
  double rest_extensor = 0.0;  ///< eps_e0

  double flexorContraction(double angle) const noexcept { return rest_flexor + radius * angle / length; }
  double extensorContraction(double angle) const noexcept { return rest_extensor - radius * angle / length; }
  double flexorForce(double pressure, double angle) const noexcept {
    return flexor.force(pressure, flexorContraction(angle)).value_or(0.0);
  }
  double extensorForce(double pressure, double angle) const noexcept {
    return extensor.force(pressure, extensorContraction(angle)).value_or(0.0);
  }
  /// Of the muscles, at rest under these pressures (002 eq. 10). [N m]
  double torque(double flexor_pressure, double extensor_pressure, double angle) const noexcept {
    return (flexorForce(flexor_pressure, angle) - extensorForce(extensor_pressure, angle)) * radius;
  }
  /// -d tau / d theta at constant pressures. [N m/rad]
  double stiffness(double flexor_pressure, double extensor_pressure, double angle) const noexcept {
    return -radius * radius / length *
           (flexor.slope(flexor_pressure, flexorContraction(angle)) +
            extensor.slope(extensor_pressure, extensorContraction(angle)));
  }
  /// The same joint as a controller sees it that knows nothing of tendons.
  AntagonistJoint withoutTendons() const noexcept {
    AntagonistJoint rigid = *this;
    rigid.flexor.k = rigid.extensor.k = std::numeric_limits<double>::infinity();
    return rigid;
  }
};

/// The pressure for a force (002 eq. 17); where none up to `highest` gives it, that one, with the force it gives.
inline MuscleCommand reachForce(const Pam& muscle, double force, double contraction, double highest) noexcept {
  if (force <= 0.0 || contraction >= muscle.highest) return {};
  const std::optional<double> pressure = muscle.pressure(force, contraction);
  if (pressure && *pressure <= highest) return {*pressure, force};
  return {highest, muscle.force(highest, contraction).value_or(0.0)};
}

/// What both muscles do besides the torque.
struct CoContraction {
  enum class Kind {
    kForce,             ///< both pull with this force at least [N]
    kStiffness,         ///< as much as makes the joint this stiff [N m/rad]
    kExtensorPressure,  ///< the extensor is held at this pressure [Pa], the flexor alone makes the torque (002 fig. 8)
  };
  Kind kind = Kind::kForce;
  double value = 0.0;
};

struct TorqueSplitSettings {
  double highest_pressure = 0.0;  ///< of the supply [Pa]
  double motor_limit = 0.0;       ///< [N m] at the joint; 0: no motor
  double crossover = 0.0;         ///< [Hz] the muscles take what is slower; 0: they are asked for everything
  CoContraction co_contraction = {};
};

struct TorqueShares {
  double flexor_pressure = 0.0, extensor_pressure = 0.0;  ///< to the valves [Pa]
  double muscles = 0.0;                                   ///< what the pressures give once they are there [N m]
  double motor = 0.0;                                     ///< [N m], within its limit
  double missing = 0.0;  ///< of the desired torque, now: what muscles and motor together do not give [N m]
};

class TorqueSplit {
 public:
  TorqueSplit(const AntagonistJoint& joint, const TorqueSplitSettings& settings) noexcept
      : joint_(joint), settings_(settings) {}

  void reset() noexcept { begun_ = false; }

  /// \param desired  torque at the joint [N m]  \param angle [rad]  \param muscles_now  torque of the muscles: by load
  /// cells, or AntagonistJoint::torque of measured pressures [N m]  \param step  since the last call [s]
  TorqueShares update(double desired, double angle, double muscles_now, double step) noexcept {
    slow_ = begun_ && settings_.crossover > 0.0
                ? slow_ + (1.0 - std::exp(-2.0 * std::numbers::pi * settings_.crossover * step)) * (desired - slow_)
                : desired;
    begun_ = true;
    TorqueShares shares = pressuresFor(slow_, angle);
    const double rest = desired - muscles_now;
    shares.motor = std::clamp(rest, -settings_.motor_limit, settings_.motor_limit);
    shares.missing = rest - shares.motor;
    return shares;
  }

  /// Pressures alone for a torque of the muscles. A muscle at its limit is helped by slackening the other one: torque
  /// goes before co-contraction.
  TorqueShares pressuresFor(double torque, double angle) const noexcept {
    const double pull = torque / joint_.radius;
    MuscleCommand flexor, extensor;
    if (settings_.co_contraction.kind == CoContraction::Kind::kExtensorPressure) {
      extensor.pressure = std::min(settings_.co_contraction.value, settings_.highest_pressure);
      extensor.force = joint_.extensorForce(extensor.pressure, angle);
      flexor = reachFlexor(extensor.force + pull, angle);
    } else {
      const double level = levelFor(pull, angle);
      flexor = reachFlexor(level + std::max(pull, 0.0), angle);
      extensor = reachExtensor(level + std::max(-pull, 0.0), angle);
      if (pull > 0.0) extensor = reachExtensor(std::min(extensor.force, flexor.force - pull), angle);
      if (pull < 0.0) flexor = reachFlexor(std::min(flexor.force, extensor.force + pull), angle);
    }
    return {flexor.pressure, extensor.pressure, (flexor.force - extensor.force) * joint_.radius, 0.0, 0.0};
  }

 private:
  MuscleCommand reachFlexor(double force, double angle) const noexcept {
    return reachForce(joint_.flexor, force, joint_.flexorContraction(angle), settings_.highest_pressure);
  }
  MuscleCommand reachExtensor(double force, double angle) const noexcept {
    return reachForce(joint_.extensor, force, joint_.extensorContraction(angle), settings_.highest_pressure);
  }

  /// The force with which both muscles pull besides the torque. Stiffness rises with it, so it is found by bisection.
  double levelFor(double pull, double angle) const noexcept {
    if (settings_.co_contraction.kind == CoContraction::Kind::kForce) return settings_.co_contraction.value;
    double low = 0.0;
    double high = std::max(joint_.flexorForce(settings_.highest_pressure, angle),
                           joint_.extensorForce(settings_.highest_pressure, angle));
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (low + high);
      const double flexor = reachFlexor(middle + std::max(pull, 0.0), angle).pressure;
      const double extensor = reachExtensor(middle + std::max(-pull, 0.0), angle).pressure;
      (joint_.stiffness(flexor, extensor, angle) < settings_.co_contraction.value ? low : high) = middle;
    }
    return high;
  }

  AntagonistJoint joint_;
  TorqueSplitSettings settings_;
  double slow_ = 0.0;  ///< the desired torque behind a low pass of first order
  bool begun_ = false;
};

}  // namespace simgap
