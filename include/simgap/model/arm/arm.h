/// \file
/// A tendon-driven arm: rigid bodies joined in a tree, pulled by muscles (000 sections III-V). SI units, z up.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "simgap/core/units.h"
#include "simgap/measure/pose_set.h"
#include "simgap/model/arm/body.h"
#include "simgap/model/arm/joint.h"
#include "simgap/model/arm/tendon.h"
#include "simgap/model/effects/extension.h"

namespace simgap {

struct ArmModel {
  std::string name;
  Eigen::Vector3d gravity = {0.0, 0.0, -kEarthGravity};  ///< [m/s^2]
  std::vector<Body> bodies;
  std::vector<Joint> joints;  ///< every joint's parent is fixed or the child of an earlier joint
  std::vector<Muscle> muscles;
  std::vector<PassiveTendon> tendons;
  std::vector<Extension> extensions;  ///< parameters in the order of their effect (arm_effect.h)
  Motor motor_defaults;
  Gearbox gearbox_defaults;

  PoseLayout poseLayout() const;
  /// Numbers that say what a pose is told to do: an angle per muscle, and of `tendons` those that take a command.
  std::size_t commands() const;
};

}  // namespace simgap
