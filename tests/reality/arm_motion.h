/// \file
/// How a tendon-driven arm moves: its own equations of motion, a judge of the simulations that shares no code with
/// them.
///
///     M(q) dv/dt + h(q, v) = sum_m -F_m dL_m/dq - viscous - Coulomb - stops,   M, h from the velocities of all parts
///     L di/dt = V - R i - K_E w,   J dw/dt = N eta K_T i - b w - Coulomb - F r
///
/// M and h are sums over parts (Kane): no recursion over bodies, no articulated inertia. The drives advance in
/// sub-steps of 1/16 ms, current implicitly; the joints in steps of 1/4 ms, semi-implicitly. Joint friction is an
/// impulse that stops a joint, or acts against its slip with the Coulomb torque.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "reality/arm_statics.h"

namespace simgap::reality {

/// A motor and its gearbox, the numbers of the reference arm's model file.
struct DriveTruth {
  double resistance = 0.8, inductance = 3.0e-4, back_emf = 0.011, torque_constant = 0.011, inertia = 2.0e-6;
  double viscous = 1.0e-6, coulomb = 0.002, supply = 12.0;
  double ratio = 72.0, efficiency = 0.72, gear_inertia = 1.0e-5, gear_viscous = 0.002, gear_coulomb = 0.03;
};

/// What a model of the arm may not know; each by its own law, none from the model's.
struct HiddenCauses {
  /// Share of the tension that guides take on the way to the body, s/sqrt(s^2 + creep^2) of it against the slip s.
  double guide_loss = 0.0, guide_creep = 1e-3;          ///< [1], [m/s]
  double command_delay = 0.0;                           ///< [s]
  double current_limit = 1e9;                           ///< of every amplifier, at once [A]
  double relaxing_share = 0.0, relaxing_time = 0.5;     ///< Maxwell branch of every cord, of k; [s]
  double supply_resistance = 0.0, supply_time = 0.005;  ///< [ohm], [s]
  double returned_efficiency = 1.0;                     ///< of the gear while the load drives the motor
  std::vector<double> gains = {};                       ///< factors on K_p, shape (muscles); empty: 1
  std::function<double(double angle, double speed)> elbow_drag =
      {};  ///< torque on the last hinge [N m], of no catalogue
};

struct MovingArm {
  Arm arm;
  std::vector<DriveTruth> drives;  ///< shape (muscles)
  HiddenCauses hidden = {};
};

/// Set-points at a time on the controllers' clock, shape (muscles) [rad].
using Setpoints = std::function<std::vector<double>(double time)>;

struct MotionRigOptions {
  double duration = 4.0;                              ///< [s]
  double settle = 3.0;                                ///< before it, under the first set-points [s]
  double muscle_rate = 100.0, capture_rate = 60.0;    ///< [Hz]
  double capture_sd = 0.17 * 3.14159265358979 / 180;  ///< per component [rad]
  double shaft_sd = 0.3 * 3.14159265358979 / 180;     ///< [rad]
  double current_sd = 0.03;                           ///< [A]
  double capture_delay = 0.0;                         ///< a frame stamped t was taken at t + capture_delay [s]
  double gain = 50.0;                                 ///< K_p of the shaft controllers at 500 Hz [V/rad]
  /// Shafts before the motion, shape (muscles) [rad]. Given: the commands are the motors' voltages [V], set at 500 Hz.
  std::vector<double> voltages_from = {};
};

/// What the rig logs of one motion.
struct MotionLog {
  const char* command = "setpoint_{}_rad";                       ///< column of a muscle's commands, here `setpoints`
  std::vector<double> times;                                     ///< [s]
  std::vector<std::vector<double>> setpoints, shafts, currents;  ///< shape (rows, muscles)
  std::vector<double> frame_times;                               ///< on the capture's clock [s]
  std::vector<Configuration> frames;
};

/// A pure function of its arguments. \param draw  numbers the noise
MotionLog recordMotion(const MovingArm& arm, const Setpoints& setpoints, const MotionRigOptions& options,
                       std::uint64_t draw);

/// The files of a motion set: muscles and joints as CSV.
std::string musclesCsv(const MotionLog& log);
std::string jointsCsv(const MotionLog& log, const Arm& arm);

}  // namespace simgap::reality
