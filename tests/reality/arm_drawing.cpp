#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <random>
#include <sstream>
#include <stdexcept>

#include "reality/arm_placement.h"
#include "reality/arm_statics.h"

namespace simgap::reality {
namespace {

// Uniform numbers that are the same with every standard library, which std::uniform_real_distribution's are not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double between(double lower, double upper) { return lower + (upper - lower) * (double(engine_() >> 11) * 0x1.0p-53); }
  int integer(int lower, int upper) { return std::min(upper, lower + int(between(0.0, upper - lower + 1.0))); }
  bool chance(double probability) { return between(0.0, 1.0) < probability; }
  Eigen::Vector3d cube(double half) {
    const double x = between(-half, half);
    const double y = between(-half, half);
    return {x, y, between(-half, half)};
  }

 private:
  std::mt19937_64 engine_;
};

Eigen::Vector3d horizontal(double azimuth) { return {std::cos(azimuth), std::sin(azimuth), 0.0}; }

// A link hangs from its frame's origin along -z. Its second part is off centre, so that gravity turns every joint.
Link drawLink(Dice& dice, const Arm& arm, int parent) {
  Link link;
  link.parent = parent;
  link.joint = dice.chance(0.5) ? Joint::kSpherical : Joint::kRevolute;
  if (parent == kTorso) {
    link.joint_in_parent = dice.cube(arm.links.empty() ? 0.05 : 0.15);
  } else {
    link.joint_in_parent = Eigen::Vector3d(0.0, 0.0, -arm.links[std::size_t(parent)].parts[0].length) + dice.cube(0.03);
  }
  link.joint_in_child = dice.cube(0.015);
  const double tilt = dice.between(-0.3, 0.3);
  link.axis = (horizontal(dice.between(-M_PI, M_PI)) + Eigen::Vector3d(0.0, 0.0, tilt)).normalized();
  if (link.joint == Joint::kRevolute && dice.chance(0.7)) {
    link.lower = dice.between(-0.6, 0.4);  // often near the rest angle, so that some poses end on a stop
    link.upper = dice.between(0.6, 2.4);
  }
  link.coulomb = dice.between(0.01, 0.05);
  link.viscous = dice.between(0.02, 0.08);
  const double length = dice.between(0.15, 0.35);
  const double mass = dice.between(0.2, 1.5);
  const double share = dice.between(0.3, 0.7);
  const Eigen::Vector3d offset = dice.cube(0.015);
  const double depth = dice.between(0.3, 0.6) * length;
  const Eigen::Vector3d axis = (Eigen::Vector3d::UnitZ() + dice.cube(0.3)).normalized();
  link.parts.push_back({0.018, length, share * mass, {0.0, 0.0, -0.5 * length}, Eigen::Vector3d::UnitZ()});
  link.parts.push_back({0.03, 0.08, (1.0 - share) * mass, offset - Eigen::Vector3d(0.0, 0.0, depth), axis});
  return link;
}

// A muscle from beside the joint of link `upper` (on that link's parent) down to link `lower`, at an azimuth about z.
// It begins near the joint's height: a line from far above would lose its lever arm as the joint bends, and
// destabilise.
Muscle drawMuscle(Dice& dice, const Arm& arm, int upper, int lower, double azimuth) {
  const Link& first = arm.links[std::size_t(upper)];
  const Link& last = arm.links[std::size_t(lower)];
  Muscle muscle;
  const double begin = first.parent == kTorso ? dice.between(0.06, 0.12) : dice.between(0.05, 0.09);
  const double height = first.parent == kTorso ? dice.between(-0.03, 0.03) : dice.between(-0.01, 0.04);
  muscle.from = {first.parent, first.joint_in_parent + begin * horizontal(azimuth) + Eigen::Vector3d(0, 0, height)};
  const double end = dice.between(0.025, 0.05);
  const double depth = dice.between(0.25, 0.6) * last.parts[0].length;
  const double skew = dice.between(-0.4, 0.4);
  muscle.to = {lower, last.joint_in_child + end * horizontal(azimuth + skew) - Eigen::Vector3d(0, 0, depth)};
  muscle.cord_rest = dice.between(0.07, 0.1);
  muscle.stiffness = dice.between(500.0, 1500.0);
  muscle.damping = dice.between(10.0, 20.0);
  muscle.spindle_radius = dice.between(0.005, 0.01);
  // The line is cut so that the cord is stretched a little in the rest pose with the shaft at 0.
  const Placement<double> rest(arm, restPose(arm), Eigen::VectorXd::Zero(freedoms(arm)));
  const double length = (rest.at(muscle.to) - rest.at(muscle.from)).norm();
  muscle.kite_line = length - muscle.cord_rest - dice.between(0.015, 0.035);
  return muscle;
}

Arm drawArm(Dice& dice, const RandomArmOptions& options) {
  Arm arm;
  const int links = dice.integer(options.min_links, options.max_links);
  const bool tree = dice.chance(options.branching);
  for (int i = 0; i < links; ++i) arm.links.push_back(drawLink(dice, arm, tree ? dice.integer(kTorso, i - 1) : i - 1));
  for (int i = 0; i < links; ++i) {
    const Link& link = arm.links[std::size_t(i)];
    const int around = link.joint == Joint::kSpherical ? 3 : 2;
    // A hinge's antagonists pull across its axis; a ball joint's surround it.
    const double first = around == 2 ? std::atan2(link.axis.x(), -link.axis.y()) : dice.between(-M_PI, M_PI);
    for (int k = 0; k < around; ++k) {
      arm.muscles.push_back(drawMuscle(dice, arm, i, i, first + 2.0 * M_PI * k / around + dice.between(-0.25, 0.25)));
    }
  }
  const int made = int(arm.muscles.size());
  const int wanted = dice.integer(std::max(4, made), std::max({4, made, options.max_muscles}));
  for (int k = made; k < wanted; ++k) {
    const int lower = dice.integer(0, links - 1);
    const int parent = arm.links[std::size_t(lower)].parent;
    const int upper = parent != kTorso && dice.chance(0.6) ? parent : lower;  // from the grandparent: two joints
    arm.muscles.push_back(drawMuscle(dice, arm, upper, lower, dice.between(-M_PI, M_PI)));
  }
  return arm;
}

std::vector<double> drawShafts(Dice& dice, const Arm& arm, double largest) {
  std::vector<double> shafts(arm.muscles.size());
  for (double& shaft : shafts) shaft = dice.between(-largest, largest);
  return shafts;
}

bool stiffEnough(Dice& dice, const Arm& arm, double stiffness) {
  const Equilibrium still = minimise(arm, std::vector<double>(arm.muscles.size()), restPose(arm));
  if (!still.converged || still.stiffness < stiffness) return false;
  if (largestRotation(arm, restPose(arm), still.configuration) > 0.7) return false;
  for (int probe = 0; probe < 2; ++probe) {
    const Equilibrium moved_arm = minimise(arm, drawShafts(dice, arm, 4.0), still.configuration);
    if (!moved_arm.converged || moved_arm.stiffness < 0.5 * stiffness) return false;
  }
  return true;
}

}  // namespace

Arm randomArm(std::uint64_t seed, const RandomArmOptions& options) {
  Dice dice(seed);
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const Arm arm = drawArm(dice, options);
    if (stiffEnough(dice, arm, options.min_stiffness)) return arm;
  }
  throw std::runtime_error("randomArm: no arm of 1000 is as stiff as " + std::to_string(options.min_stiffness) +
                           " N m/rad");
}

std::vector<double> randomShafts(const Arm& arm, std::uint64_t seed) {
  Dice dice(seed);
  for (double largest = 4.0;; largest *= 0.95) {
    const std::vector<double> shafts = drawShafts(dice, arm, largest);
    const Equilibrium pose = followFromRest(arm, shafts);
    const bool smooth = pose.converged && pose.stiffness > 0.3 && pose.largest_jump < 0.25;
    const bool near = largestRotation(arm, restPose(arm), pose.configuration) < 1.4;
    if ((smooth && near && largestStrain(arm, shafts, pose.configuration) < 0.8) || largest < 0.01) return shafts;
  }
}

Arm referenceArm() {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  Link humerus;
  humerus.coulomb = humerus.viscous = 0.05;
  humerus.parts = {{0.018, 0.28, 0.31, {0, 0, -0.14}, z}, {0.022, 0.10, 0.74, {0, 0.0056757, -0.1187162}, z}};
  Link forearm;
  forearm.parent = 0;
  forearm.joint = Joint::kRevolute;
  forearm.joint_in_parent = {0, 0, -0.28};
  forearm.lower = 0.0;
  forearm.upper = 2.3562;
  forearm.coulomb = forearm.viscous = 0.02;
  forearm.parts = {{0.015, 0.24, 0.18, {0, 0, -0.12}, z}, {0.03, 0.08, 0.44, {0, 0.0042273, -0.1171818}, z}};
  Arm arm;
  arm.links = {humerus, forearm};
  arm.muscles = {
      {{kTorso, {0.01, 0.072, 0.055}}, {0, {0.004, 0.024, -0.112}}, 0.0839, 0.08, 900, 15, 0.006},
      {{kTorso, {0.074, 0.004, 0.066}}, {0, {0.025, 0.002, -0.121}}, 0.1033, 0.08, 900, 15, 0.006},
      {{kTorso, {0.006, -0.079, 0.05}}, {0, {0.003, -0.026, -0.108}}, 0.0767, 0.08, 900, 15, 0.006},
      {{kTorso, {-0.142, 0.084, -0.058}}, {0, {-0.012, 0.021, -0.082}}, 0.0564, 0.08, 800, 15, 0.006},
      {{kTorso, {-0.121, -0.092, -0.196}}, {0, {-0.011, -0.022, -0.071}}, 0.0906, 0.08, 800, 15, 0.006},
      {{kTorso, {-0.102, -0.071, -0.046}}, {0, {0.014, -0.021, -0.052}}, 0.0365, 0.08, 850, 15, 0.006},
      {{kTorso, {-0.083, -0.018, 0.064}}, {0, {0.021, 0.003, 0.031}}, 0.0211, 0.08, 850, 15, 0.006},
      {{kTorso, {-0.089, 0.031, -0.022}}, {0, {-0.021, 0.018, -0.033}}, -0.0199, 0.08, 850, 15, 0.006},
      {{kTorso, {-0.012, 0.043, 0.048}}, {1, {0.002, 0.026, -0.046}}, 0.2846, 0.08, 950, 15, 0.006},
      {{0, {0.003, 0.021, -0.152}}, {1, {0, 0.021, -0.041}}, 0.079, 0.08, 900, 15, 0.006},
      {{0, {0, -0.022, -0.121}}, {1, {0.001, -0.026, 0.029}}, 0.0401, 0.08, 950, 15, 0.006},
  };
  return arm;
}

// ---------------------------------------------------------------------------------------------- model file

namespace {

constexpr const char* kDrive =
    "motor_defaults: {resistance_ohm: 0.8, inductance_H: 0.0003, back_emf_constant_Vs: 0.011, "
    "torque_constant_Nm_A: 0.011, inertia_kg_m2: 2.0e-6, viscous_friction_Nms: 1.0e-6, coulomb_friction_Nm: 0.002, "
    "supply_voltage_V: 12}\n"
    "gearbox_defaults: {ratio: 72, efficiency: 0.72, inertia_kg_m2: 1.0e-5, viscous_friction_Nms: 0.002, "
    "coulomb_friction_Nm: 0.03}\n";

// The shortest text that reads back as the same number.
std::string text(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

std::string list(const Eigen::Vector3d& v) { return "[" + text(v.x()) + ", " + text(v.y()) + ", " + text(v.z()) + "]"; }

void writeJoint(std::ostream& out, const Link& link, int index, bool coulomb) {
  const bool revolute = link.joint == Joint::kRevolute;
  out << "  - {name: " << jointName(index) << ", type: " << (revolute ? "revolute" : "spherical")
      << ", parent: " << linkName(link.parent) << ", child: " << linkName(index)
      << ", parent_position_m: " << list(link.joint_in_parent) << ", child_position_m: " << list(link.joint_in_child);
  if (revolute) out << ", axis: " << list(link.axis);
  if (revolute && std::isfinite(link.lower)) out << ", lower_limit_rad: " << text(link.lower);
  if (revolute && std::isfinite(link.upper)) out << ", upper_limit_rad: " << text(link.upper);
  out << ", coulomb_friction_Nm: " << text(coulomb ? link.coulomb : 0.0)
      << ", viscous_friction_Nms: " << text(link.viscous) << "}\n";
}

void writeMuscle(std::ostream& out, const Muscle& muscle, int index) {
  out << "  - name: " << muscleName(index) << "\n    attachments: [{body: " << linkName(muscle.from.link)
      << ", point_m: " << list(muscle.from.point) << "}, {body: " << linkName(muscle.to.link)
      << ", point_m: " << list(muscle.to.point) << "}]\n    kite_line_length_m: " << text(muscle.kite_line)
      << "\n    shock_cord: {rest_length_m: " << text(muscle.cord_rest) << ", stiffness_N_m: " << text(muscle.stiffness)
      << ", damping_Ns_m: " << text(muscle.damping) << "}\n    spindle_radius_m: " << text(muscle.spindle_radius)
      << "\n";
}

}  // namespace

std::string linkName(int link) { return link == kTorso ? "torso" : "link" + std::to_string(link + 1); }
std::string jointName(int link) { return "joint" + std::to_string(link + 1); }
std::string muscleName(int muscle) { return "muscle" + std::to_string(muscle + 1); }

std::string toYaml(const Arm& arm, const YamlOptions& options) {
  std::ostringstream out;
  out << "format: simgap/arm/1\nname: statics-arm\ngravity_m_s2: " << list(arm.gravity)
      << "\nbodies:\n  - {name: torso, fixed: true}\n";
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    out << "  - name: " << linkName(int(i)) << "\n    parts:\n";
    for (std::size_t k = 0; k < arm.links[i].parts.size(); ++k) {
      const Part& part = arm.links[i].parts[k];
      out << "      - {name: part" << k + 1 << ", shape: cylinder, radius_m: " << text(part.radius)
          << ", length_m: " << text(part.length) << ", mass_kg: " << text(part.mass)
          << ", position_m: " << list(part.position) << ", axis: " << list(part.axis) << "}\n";
    }
  }
  out << "joints:\n";
  for (std::size_t i = 0; i < arm.links.size(); ++i) writeJoint(out, arm.links[i], int(i), options.coulomb);
  out << kDrive << "muscles:\n";
  for (std::size_t i = 0; i < arm.muscles.size(); ++i) writeMuscle(out, arm.muscles[i], int(i));
  return out.str();
}

}  // namespace simgap::reality
