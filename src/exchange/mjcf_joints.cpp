// MuJoCo's constraints give way by (1 - d) tc^2 times the acceleration that they hold back: its defaults (d = 0.9 to
// 0.95, tc = 0.02 s) let a light finger tip rest tens of degrees beyond its stop. tc is the least that MuJoCo takes,
// two time steps. A d closer to 1 lets light limbs with damped lines chatter at a stop (data/finger: from 0.997 on), so
// what is left is said: a torque tau rests (1 - d) tc^2 tau / M beyond a stop, with the inertia M that the joint moves
// in the drawn pose while all others give way (MuJoCo's 1 / dof_invweight0).
#include "mjcf_joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "arm_exchange.h"
#include "drawn_mass.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/units.h"
#include "simgap/model/arm/kinematics.h"
#include "xml_text.h"

namespace simgap {
namespace {

constexpr double kTimeConstant = 2 * kMjcfTimeStep;  ///< [s]
constexpr double kStopImpedance = 0.99;
constexpr double kCouplingImpedance = 0.9999;
constexpr double kGivesWay = (1.0 - kStopImpedance) * kTimeConstant * kTimeConstant;  ///< [s^2] of a stop
constexpr double kStatedTorque = 0.1;  ///< [N m] for which it is said how far a stop gives way

/// ` solref="…" solimp="…"`, with `kind` behind each of the two names.
std::string stiff(std::string_view kind, double impedance) {
  return fmt::format(" solref{0}=\"{1} 1\" solimp{0}=\"{2} {2} 0.001\"", kind, kTimeConstant, impedance);
}

/// A joint without any way to go: two equal numbers limit nothing in MuJoCo, an equality does.
bool held(const Joint& joint) { return joint.hasAxis() && joint.lower_limit == joint.upper_limit; }

bool stops(const Joint& joint) {
  return joint.hasAxis() && !held(joint) &&
         (joint.lower_limit > -Joint::kUnlimited || joint.upper_limit < Joint::kUnlimited);
}

/// Its own, and what motors at it lose: MuJoCo's have no friction.
double dampingOf(const ArmModel& model, const Joint& joint) {
  double damping = joint.viscous_friction;
  for (const PassiveTendon& drive : model.tendons) {
    if (drive.kind->name == "joint-motor" && &model.joints[drive.between[0].joint] == &joint) damping += drive.p[3];
  }
  return damping;
}

/// Acceleration of each joint of the drawn pose per force on it; 0 of a ball.
std::vector<double> mobilityOf(const ArmModel& model) {
  const std::vector<BodyInWorld> placed = bodiesInWorld(model, std::vector<JointPosition>(model.joints.size()));
  std::vector<DrawnBody> bodies;  // one per joint, its child
  std::vector<DrawnDof> dofs;
  std::vector<Eigen::Index> first;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const auto carrier = std::ranges::find(model.joints, joint.parent, &Joint::child);
    const BodyInWorld& child = placed[joint.child];
    const MassProperties mass = massProperties(model.bodies[joint.child]);
    bodies.push_back(
        {carrier == model.joints.end() ? -1 : static_cast<int>(carrier - model.joints.begin()),
         {mass.mass, child * mass.centre_of_mass, child.rotation * mass.inertia * child.rotation.transpose()}});
    const Eigen::Vector3d pivot = child * joint.child_position;
    first.push_back(joint.hasAxis() ? std::ssize(dofs) : -1);
    for (int k = 0; k < joint.degreesOfFreedom(); ++k) {
      const Eigen::Vector3d axis = joint.hasAxis() ? joint.axis : Eigen::Vector3d(Eigen::Vector3d::Unit(k));
      dofs.push_back({j, joint.slides(), pivot, child.rotation * (joint.child_orientation * axis)});
    }
  }
  const Eigen::VectorXd all = drawnMobility(bodies, dofs);
  std::vector<double> mobility;
  for (const Eigen::Index dof : first) mobility.push_back(dof < 0 ? 0.0 : all[dof]);
  return mobility;
}

/// How far the softest stop gives way, in the words of a remark; empty: no hinge has one.
std::string softestStop(const ArmModel& model) {
  const std::vector<double> mobility = mobilityOf(model);
  const Joint* softest = nullptr;
  double most = 0.0;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (!stops(model.joints[j]) || model.joints[j].slides()) continue;
    if (softest != nullptr && !(mobility[j] > most)) continue;
    softest = &model.joints[j];
    most = mobility[j];
  }
  if (softest == nullptr || !std::isfinite(most)) return {};
  const double way = kGivesWay * most * kStatedTorque;
  return fmt::format(": {} Nm press '{}', the lightest behind a stop, {:.2g} deg beyond it", kStatedTorque,
                     softest->name, toDegrees(way));
}

}  // namespace

std::string mjcfJoint(const ArmModel& model, const Joint& j, const Eigen::Isometry3d& frame,
                      const std::string& indent) {
  std::string text = fmt::format("{}<joint name=\"{}\" type=\"{}\" pos=\"{}\"", indent, xmlText(j.name),
                                 kindOf(j.type).mjcf, xmlNumbers(frame * j.child_position));
  if (j.hasAxis()) text += fmt::format(" axis=\"{}\"", xmlNumbers(frame.linear() * (j.child_orientation * j.axis)));
  const bool lower = j.lower_limit > -Joint::kUnlimited, upper = j.upper_limit < Joint::kUnlimited;
  if (stops(j)) {
    text += fmt::format(" range=\"{} {}\"", lower ? j.lower_limit : -1e3, upper ? j.upper_limit : 1e3);
    text += stiff("limit", kStopImpedance);
  }
  if (const double damping = dampingOf(model, j); damping > 0.0) text += fmt::format(" damping=\"{}\"", damping);
  if (j.coulomb_friction > 0.0) text += fmt::format(" frictionloss=\"{}\"", j.coulomb_friction);
  if (j.spring_stiffness > 0.0) text += fmt::format(" stiffness=\"{}\"", j.spring_stiffness);
  if (j.spring_stiffness > 0.0 && j.hasAxis()) text += fmt::format(" springref=\"{}\"", j.spring_rest);
  return text + "/>\n";
}

std::string mjcfCouplings(const ArmModel& model) {
  std::string text;
  for (const Joint& joint : model.joints) {
    if (held(joint)) {
      text += fmt::format("    <joint joint1=\"{}\" polycoef=\"{} 0 0 0 0\"{}/>\n", xmlText(joint.name),
                          joint.lower_limit, stiff("", kCouplingImpedance));
    }
    if (!joint.follows()) continue;
    text += fmt::format("    <joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{} {} 0 0 0\"{}/>\n", xmlText(joint.name),
                        xmlText(model.joints[joint.leader].name), joint.coupling_offset, joint.coupling_ratio,
                        stiff("", kCouplingImpedance));
  }
  return text;
}

void nameSoftJoints(const ArmModel& model, RemarkList& remarks) {
  for (const Joint& joint : model.joints) {
    if (!joint.hasAxis() && joint.child_orientation.coeffs() != Eigen::Quaterniond::Identity().coeffs()) {
      remarks.add(fmt::format("ball '{}' in a frame of its own", joint.name),
                  "its position is written in the child's frame");
    }
    if (joint.coulomb_friction > 0.0) {
      remarks.add("joint friction", "frictionloss: MuJoCo's is soft, a robot that it holds creeps");
    }
    if (held(joint)) remarks.add("joints held in one place", "an equality constraint: soft, but written stiff");
    if (joint.follows()) remarks.add("coupled joints", "an equality constraint: soft, but written stiff");
  }
  if (std::ranges::any_of(model.joints, stops)) {
    remarks.add("joint limits", fmt::format("MuJoCo's are soft: written stiff, they give way by {:.1g} s^2 of the "
                                            "acceleration that they hold back{}",
                                            kGivesWay, softestStop(model)));
  }
}

}  // namespace simgap
