/// \file
/// What makes a motor's voltage of a command, at the ticks of a muscle's controller (000 section VII: 500 Hz).
/// One file per kind in src/simulate/controllers.
#pragma once

#include <array>
#include <memory>

#include "simgap/core/yaml.h"
#include "simgap/measure/motion_commands.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

/// What a controller is told of its muscle at a tick (000 section VI).
struct MuscleSensors {
  double shaft = 0.0;           ///< [rad]
  double shaft_velocity = 0.0;  ///< [rad/s]
  double force = 0.0;           ///< [N]
  double current = 0.0;         ///< [A]
  double cord_expansion = 0.0;  ///< L_S - L_SR [m]
};

struct ControllerOptions {
  double rate = 500.0;       ///< [Hz]
  double shaft_gain = 50.0;  ///< K_p [V/rad]
  /// Poles of the force controller's feedback and of its observer, as rates of decay, each different [1/s].
  std::array<double, 3> force_rates = {60.0, 80.0, 1500.0};
  std::array<double, 4> observer_rates = {200.0, 250.0, 300.0, 2000.0};
  /// Of the joints' PD control (controllers/joint_position.h).
  double joint_stiffness = 30.0, joint_damping = 2.0;  ///< [N m/rad], [N m s/rad]
  double least_force = 5.0;                            ///< of every muscle [N]
  bool operator==(const ControllerOptions&) const = default;
  /// Reads a `controllers:` section; what is missing keeps its value. \throws ConfigError
  static ControllerOptions read(const YamlNode& node);
  std::string toYaml() const;
};

/// One muscle's controller.
class MuscleController {
 public:
  virtual ~MuscleController() = default;
  /// Forgets what came before.
  virtual void reset() = 0;
  /// The voltage until the next tick, before the supply limits it [V]. \param command  [rad], [V] or [N]
  virtual double voltage(double command, const MuscleSensors& sensors) = 0;
};

/// \param rate  of its ticks [Hz]
std::unique_ptr<MuscleController> makeController(CommandKind kind, const Muscle& muscle,
                                                 const ControllerOptions& options);

}  // namespace simgap
