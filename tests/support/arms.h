/// \file
/// Small arms for tests of the simulation, and what can be said of their motion from the model alone.
#pragma once

#include <filesystem>
#include <random>
#include <span>
#include <vector>

#include "simgap/model/arm/arm.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap::test {

/// \name Parts of a body; positions and axes in the body's frame.
///@{
Part sphere(double mass, const Eigen::Vector3d& position, double radius = 0.02);
Part cylinder(double mass, const Eigen::Vector3d& position, const Eigen::Vector3d& axis, double radius = 0.02,
              double length = 0.2);
Part box(double mass, const Eigen::Vector3d& position, const Eigen::Vector3d& size);
///@}

/// A fixed torso (body 0), the drives of the example arm as defaults, no joints and no muscles.
ArmModel torso();

/// Hangs a body on body `parent`; its joint has no friction and no limits.
/// \returns the joint, to be changed at will; its child is the last body.
Joint& addLink(ArmModel& model, int parent, JointType type, const Eigen::Vector3d& parent_position,
               const std::vector<Part>& parts);

/// A cord of 900 N/m whose line and rest length together are `slack_length` long with the shaft at 0. A cord without
/// length (`slack_length` 0) pulls with k L: many things can then be worked out on paper.
Muscle& addMuscle(ArmModel& model, const Attachment& from, const Attachment& to, double slack_length);

/// A hinge about x (or a ball joint) in the torso's origin and 2 kg at 0.15 m below it, in a sphere of 20 mm.
ArmModel pendulum(JointType type = JointType::kRevolute);
inline constexpr double kPendulumMass = 2.0;
inline constexpr double kPendulumLength = 0.15;
inline constexpr double kPendulumInertia = kPendulumMass * (kPendulumLength * kPendulumLength + 0.4 * 0.02 * 0.02);
inline constexpr double kGravity = 9.81;

/// data/NAME/arm.yaml of the source tree.
ArmModel exampleArm(const std::string& name = "arm");
std::filesystem::path dataFile(const std::string& name);

/// \name Positions of a joint.
///@{
JointPosition hingeAt(double angle);
JointPosition ballAt(double angle, const Eigen::Vector3d& axis);  ///< axis of any length
///@}

Eigen::Vector3d randomDirection(std::mt19937& random);
Eigen::Quaterniond randomRotation(std::mt19937& random);
double uniform(std::mt19937& random, double lower, double upper);

/// Largest jointError of two positions of an arm [rad].
double largestError(const ArmModel& model, std::span<const JointPosition> a, std::span<const JointPosition> b);

/// Angular velocities of the joints (in the child's frame; revolute: about the axis, -, -) that lead from one position
/// to the next in one step. Semi-implicit Euler turns every joint by exactly dt times its new velocity.
std::vector<Eigen::Vector3d> velocitiesBetween(const ArmModel& model, std::span<const JointPosition> before,
                                               std::span<const JointPosition> after, double step);

/// Energy and momentum of the bodies, summed over the parts: no mass matrix, no compound inertia.
struct Mechanics {
  double kinetic = 0.0;                                        ///< [J]
  double potential = 0.0;                                      ///< [J] of gravity alone
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();  ///< [kg m^2/s] about the world's origin
  double energy() const { return kinetic + potential; }
};
Mechanics mechanics(const ArmModel& model, std::span<const JointPosition> positions,
                    std::span<const Eigen::Vector3d> velocities);

}  // namespace simgap::test
