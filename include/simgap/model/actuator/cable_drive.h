/// \file
/// A joint that a motor turns through a Bowden cable, its controller, and what that controller may believe of the
/// friction (003 sections 2.2 and 2.3) as a file: `format: simgap/cable-drive/1` (docs/formats.md). SI units.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/model/actuator/fitted_model.h"
#include "simgap/model/actuator/trajectory_control.h"

namespace simgap {

/// What the controller compensates.
struct FrictionCompensation {
  std::string name;
  DriveFeedForward drive;
  double share = 1.0;  ///< of the friction
};

struct CableDrive {
  std::string name;
  DriveFeedForward drive;  ///< friction as it is, and the torque that a current gives
  /// \name Motor; its current follows at once
  ///@{
  double motor_inertia = 0.0;  ///< of the rotor [kg m^2]
  double counts = 0.0;         ///< of its encoder per turn; 0: it reads exactly
  ///@}
  /// \name Cable, as a spring and a damper at the joint
  ///@{
  double stiffness = 0.0;  ///< [N m/rad]
  double damping = 0.0;    ///< [N m s/rad]
  ///@}
  /// \name What the joint turns
  ///@{
  double inertia = 0.0;           ///< [kg m^2]
  double weight = 0.0;            ///< mass times gravity times distance from the axis [N m]
  double hangs_at = 0.0;          ///< angle at which it hangs down [rad]
  double viscous_friction = 0.0;  ///< [N m s]
  ///@}
  /// \name Controller
  ///@{
  TrajectorySettings control;
  double rate = 8000.0;          ///< [Hz]
  double set_point_rate = 50.0;  ///< at which it is told where to go [Hz]
  double velocity = 0.0;         ///< of the trapezoids [rad/s]
  double acceleration = 0.0;     ///< likewise [rad/s^2]
  double observer = 0.0;         ///< bandwidth of VelocityObserver [rad/s]
  ///@}
  std::vector<FrictionCompensation> compensations;  ///< the first compensates nothing: "none"

  /// Torque of the weight [N m]. \param joint [rad]
  double weightAt(double joint) const { return weight * std::sin(joint - hangs_at); }
};

/// \param model  reads the file of a friction model that `fit-friction` has left (its path as it stands in the file)
/// \throws ConfigError: all that YamlNode and feedForward refuse, two compensations of one name
CableDrive readCableDrive(const YamlNode& root, const std::function<FittedModel(const std::string& file)>& model);

}  // namespace simgap
