/// \file
/// A tendon-driven arm: rigid bodies joined in a tree, pulled by muscles (000 sections III-V). SI units, z up.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "simgap/core/rotation.h"
#include "simgap/measure/pose_set.h"
#include "simgap/model/effects/extension.h"

namespace simgap {

/// A primitive of a compound body, with its mass spread evenly (000 section III-B).
struct Part {
  enum class Shape { kSphere, kCylinder, kBox };
  std::string name;
  Shape shape = Shape::kCylinder;
  double radius = 0.0;                                 ///< [m] sphere, cylinder
  double length = 0.0;                                 ///< [m] cylinder, along `axis`
  Eigen::Vector3d size = Eigen::Vector3d::Zero();      ///< [m] box, along the body's axes
  double mass = 0.0;                                   ///< [kg]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m] centre, in the body's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();     ///< of a cylinder, in the body's frame, unit length
  bool operator==(const Part&) const = default;
};

struct Body {
  std::string name;
  bool fixed = false;  ///< its frame is the world frame
  std::vector<Part> parts;
  bool operator==(const Body&) const = default;
};

/// Mass, centre of mass and inertia of a body, in the body's frame.
struct MassProperties {
  double mass = 0.0;                                         ///< [kg]
  Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();         ///< [kg m^2] about the centre of mass
};

/// Sums the parts by the parallel-axis theorem.
MassProperties massProperties(const Body& body);

/// Child frame in parent frame: translate by parent_position, rotate by the joint, translate by -child_position.
struct Joint {
  std::string name;
  JointType type = JointType::kSpherical;
  int parent = 0;                                             ///< index into bodies
  int child = 0;                                              ///< index into bodies
  Eigen::Vector3d parent_position = Eigen::Vector3d::Zero();  ///< [m] in the parent's frame
  Eigen::Vector3d child_position = Eigen::Vector3d::Zero();   ///< [m] in the child's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();            ///< revolute: in the parent's frame, unit length
  double lower_limit = -kUnlimited;                           ///< [rad] revolute
  double upper_limit = kUnlimited;                            ///< [rad] revolute
  double coulomb_friction = 0.0;                              ///< [N m] static = kinetic
  double viscous_friction = 0.0;                              ///< [N m s]

  static constexpr double kUnlimited = 1e9;
  bool operator==(const Joint&) const = default;
  int degreesOfFreedom() const { return type == JointType::kSpherical ? 3 : 1; }
};

/// DC motor (000 eq. 8-9).
struct Motor {
  double resistance = 0.0;         ///< R [ohm]
  double inductance = 0.0;         ///< L [H]
  double back_emf_constant = 0.0;  ///< K_E [V s]
  double torque_constant = 0.0;    ///< K_T [N m/A]
  double inertia = 0.0;            ///< J_M [kg m^2]
  double viscous_friction = 0.0;   ///< mu_M [N m s]
  double coulomb_friction = 0.0;   ///< tau_CM [N m]
  double supply_voltage = 0.0;     ///< [V]
  bool operator==(const Motor&) const = default;
};

/// Gearbox (000 eq. 10-11).
struct Gearbox {
  double ratio = 1.0;             ///< N = omega_M / omega_G
  double efficiency = 1.0;        ///< eta; multiplies when back-driven too, as printed
  double inertia = 0.0;           ///< J_G [kg m^2]
  double viscous_friction = 0.0;  ///< mu_G [N m s]
  double coulomb_friction = 0.0;  ///< tau_CG [N m]
  bool operator==(const Gearbox&) const = default;
};

/// Elastic cord: a linear spring and damper that only pulls (000 eq. 2-4).
struct ShockCord {
  double rest_length = 0.0;  ///< L_SR [m]
  double stiffness = 0.0;    ///< k [N/m]
  double damping = 0.0;      ///< D [N s/m]

  static constexpr double kLinearRange = 0.8;  ///< of the rest length (000 eq. 2)

  /// Force of a cord of length L_S that lengthens at `rate`: max(0, k (L_S - L_SR) + D dL_S/dt) while taut, 0 when
  /// slack (000 eq. 3-4). [N]
  double force(double length, double rate) const noexcept {
    const double expansion = length - rest_length;
    return expansion > 0.0 ? std::max(0.0, stiffness * expansion + damping * rate) : 0.0;
  }
};

struct Attachment {
  int body = 0;                                     ///< index into bodies
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< [m] in the body's frame
};

/// DC motor, gearbox, kite line wound on a spindle, shock cord (000 section V).
struct Muscle {
  std::string name;
  std::array<Attachment, 2> attachments;
  double kite_line_length = 0.0;  ///< L_K0 [m]; may be negative: the straight, virtual line leaves out the bones
  ShockCord shock_cord;
  double spindle_radius = 0.0;         ///< r [m]
  double potentiometer_initial = 0.0;  ///< S_P0 [rad]
  Motor motor;
  Gearbox gearbox;

  /// Line left at shaft angle phi [rad]: L_K = L_K0 - r phi (000 eq. 12 integrated). [m]
  double kiteLineLength(double shaft) const noexcept { return kite_line_length - spindle_radius * shaft; }
};

struct ArmModel {
  std::string name;
  Eigen::Vector3d gravity = {0.0, 0.0, -9.81};  ///< [m/s^2]
  std::vector<Body> bodies;
  std::vector<Joint> joints;  ///< every joint's parent is fixed or the child of an earlier joint
  std::vector<Muscle> muscles;
  std::vector<Extension> extensions;  ///< parameters in the order of their effect (arm_effect.h)
  Motor motor_defaults;
  Gearbox gearbox_defaults;

  PoseLayout poseLayout() const;
};

}  // namespace simgap
