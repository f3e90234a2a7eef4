/// \file
/// Where a tendon-driven arm comes to rest, from its potential energy alone:
///
///   E(q, phi) = - sum_parts m g.x(q)  +  sum_muscles 1/2 k max(0, L(q) - L_K0 + r phi - L_SR)^2
///
/// A judge of the simulations: it shares no code with them, and knows neither forces nor Jacobians. Derivatives are
/// differences of E (complex step for the first, a central difference of that for the second), so a wrong lever arm,
/// sign or frame in a simulation cannot be repeated here. Dynamics, cord damping and friction do not move an
/// equilibrium; they are carried only so that `toYaml` can write a complete arm.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace simgap::reality {

inline constexpr int kTorso = -1;  ///< index of the fixed body, whose frame is the world

/// A solid cylinder; on its own a statics needs only mass and position.
struct Part {
  double radius = 0.02;                                ///< [m]
  double length = 0.1;                                 ///< [m]
  double mass = 0.5;                                   ///< [kg]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< its centre in the link's frame [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();     ///< unit vector, in the link's frame
};

enum class Joint { kSpherical, kRevolute };

/// A moving body and the joint that carries it.
struct Link {
  int parent = kTorso;  ///< a link with a smaller index, or kTorso
  Joint joint = Joint::kSpherical;
  Eigen::Vector3d joint_in_parent = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d joint_in_child = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();            ///< revolute: unit vector, the same in both frames
  double lower = -std::numeric_limits<double>::infinity();    ///< revolute [rad]
  double upper = std::numeric_limits<double>::infinity();     ///< revolute [rad]
  double coulomb = 0.0;                                       ///< [N m]
  double viscous = 0.0;                                       ///< [N m s]
  std::vector<Part> parts;
  /// \name What a model may not know of; 0: nothing
  ///@{
  double skin = 0.0;       ///< spherical: energy skin/2 (3 - trace R), about skin * angle^2 / 2 [N m/rad]
  double stop = 0.0;       ///< revolute: an elastic stop, 1/2 stop (angle - stop_from)^2 above stop_from [N m/rad]
  double stop_from = 0.0;  ///< [rad]
  ///@}
};

struct Attachment {
  int link = kTorso;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< in the link's frame [m]
};

struct Muscle {
  Attachment from;
  Attachment to;
  double kite_line = 0.1;         ///< L_K0 [m]
  double cord_rest = 0.08;        ///< L_SR [m]
  double stiffness = 900.0;       ///< k [N/m]
  double damping = 15.0;          ///< [N s/m]
  double spindle_radius = 0.006;  ///< r [m]
  /// \name What a model may not know of; 0: nothing
  ///@{
  double coiling = 0.0;    ///< growth of the radius as the line winds up: r phi + coiling phi^2 / 2 [m/rad^2]
  double hardening = 0.0;  ///< F = k x (1 + hardening (x / L_SR)^2) (1)
  /// It bends round a joint: over a sphere about the joint's centre (spherical) or a cylinder about its axis
  /// (revolute).
  int wrap_link = kTorso;    ///< the link whose joint it is; kTorso: none
  double wrap_radius = 0.0;  ///< [m], smaller than the distance of either end
  ///@}
};

struct Arm {
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};
  std::vector<Link> links;
  std::vector<Muscle> muscles;
};

/// Position of one joint. Only the member of the joint's type has a meaning.
struct JointPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< spherical: parent_from_child
  double angle = 0.0;                                      ///< revolute [rad]
};
using Configuration = std::vector<JointPose>;  ///< one entry per link

/// Per link a generalised torque: 3 numbers in the child's frame (spherical) or 1 about the axis (revolute) [N m].
using JointTorques = std::vector<Eigen::VectorXd>;

/// Spherical joints at identity, revolute ones at 0.3 rad or the limit next to it.
Configuration restPose(const Arm& arm);

/// E at a configuration [J]. `shafts` in the order of the muscles [rad], positive winds up.
double totalEnergy(const Arm& arm, std::span<const double> shafts, const Configuration& configuration);

/// -dE/dq: what gravity and muscles do to each joint; a joint stop's reaction and friction are not in it. An arm may
/// rest wherever the norm of every entry is within the joint's Coulomb torque.
JointTorques jointTorque(const Arm& arm, std::span<const double> shafts, const Configuration& configuration);

struct Equilibrium {
  Configuration configuration;
  JointTorques residual;      ///< jointTorque, less the reaction of the joint stops
  double gradient_norm = 0;   ///< largest component of `residual` [N m]
  bool converged = false;     ///< gradient_norm <= 1e-10 N m
  double stiffness = 0;       ///< smallest eigenvalue of E's Hessian without the joints at their stop [N m/rad];
                              ///< > 0: stable; +infinity when every joint is held by its stop
  std::vector<bool> at_stop;  ///< per link: pressed against a joint limit
  double largest_jump = 0;    ///< followFromRest: largest joint rotation within one step of the shafts [rad]
  int iterations = 0;         ///< Newton steps in all
};

/// The minimum of E that lies downhill of `start` (clamped to the joint limits), by damped Newton.
Equilibrium minimise(const Arm& arm, std::span<const double> shafts, const Configuration& start);

/// The minimum that an arm reaches whose shafts move slowly and in proportion from 0 to `shafts`, from the rest pose.
/// A `largest_jump` far above the travel divided by `steps` tells that the branch ended on the way: which minimum the
/// arm then falls into is a matter of its dynamics.
Equilibrium followFromRest(const Arm& arm, std::span<const double> shafts, int steps = 24);

/// Largest expansion of a cord, relative to its rest length (1).
double largestStrain(const Arm& arm, std::span<const double> shafts, const Configuration& configuration);

struct RandomArmOptions {
  int min_links = 1;
  int max_links = 4;
  int max_muscles = 14;        ///< at least 4 are made; 3 per spherical and 2 per revolute joint are always there
  double branching = 0.4;      ///< probability that the links form any tree instead of a chain
  double min_stiffness = 0.8;  ///< smallest Hessian eigenvalue with the shafts at 0 [N m/rad]; half of it when moved
};

/// A plausible arm with antagonists around each joint; a pure function of its arguments.
/// \throws std::runtime_error when 1000 drawn arms are not stiff enough.
Arm randomArm(std::uint64_t seed, const RandomArmOptions& options = {});

/// The two-link arm with eleven muscles: links humerus and forearm, muscles in the order of its model file.
Arm referenceArm();

/// Shaft angles, at most 4 rad, that lead without a jump to a stable pose within 1.4 rad of rest, cords within 80 %.
std::vector<double> randomShafts(const Arm& arm, std::uint64_t seed);

/// \name Names in the model file: link1, joint1, muscle1 for index 0.
///@{
std::string linkName(int link);  ///< "torso" for kTorso
std::string jointName(int link);
std::string muscleName(int muscle);
///@}

struct YamlOptions {
  bool coulomb = true;  ///< false: Coulomb friction of the joints 0, so that the arm rests in the minimum itself
};

/// The arm as a model file, `format: simgap/arm/1`, with numbers that read back exactly. Infinite limits are left out.
std::string toYaml(const Arm& arm, const YamlOptions& options = {});

}  // namespace simgap::reality
