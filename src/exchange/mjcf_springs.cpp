// `springdamper`: a joint's time constant and damping ratio, of which MuJoCo's compiler makes
//
//   stiffness = M / (time constant * damping ratio)^2,   damping = 2 M / time constant
//
// instead of what is stated. M is the inertia [kg m^2] or mass [kg] that the joint moves in the drawn pose while all
// other joints give way: 1 / (mass matrix)^-1_jj, of a ball by the mean over its three axes
// (mjCModel::AutoSpringDamper).
#include <fmt/format.h>

#include <cmath>

#include "drawn_mass.h"
#include "mjcf_robot.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

std::vector<Eigen::Isometry3d> placedBodies(const MjcfRobot& robot) {
  std::vector<Eigen::Isometry3d> placed;
  for (const MjcfBody& body : robot.bodies) {
    placed.push_back(body.parent < 0 ? body.frame : placed[body.parent] * body.frame);
  }
  return placed;
}

void addDofs(const MjcfJoint& joint, std::size_t body, const Eigen::Isometry3d& frame, std::vector<DrawnDof>& dofs) {
  const Eigen::Vector3d point = frame * joint.position;
  if (joint.kind->has_axis) {
    dofs.push_back({body, joint.kind->slides, point, frame.linear() * joint.axis, joint.armature});
    return;
  }
  for (int k = 0; k < 3; ++k) dofs.push_back({body, false, point, frame.linear().col(k), joint.armature});
}

}  // namespace

void setSpringDampers(MjcfRobot& robot) {
  const std::vector<Eigen::Isometry3d> placed = placedBodies(robot);
  std::vector<DrawnDof> dofs;
  std::vector<std::pair<MjcfJoint*, Eigen::Index>> joints;  // with their first dofs
  bool asked = false;
  for (std::size_t b = 0; b < robot.bodies.size(); ++b) {
    for (MjcfJoint& joint : robot.bodies[b].joints) {
      joints.emplace_back(&joint, std::ssize(dofs));
      addDofs(joint, b, placed[b], dofs);
      asked = asked || joint.springDamped();
    }
  }
  if (!asked) return;
  std::vector<DrawnBody> bodies;
  for (std::size_t b = 0; b < robot.bodies.size(); ++b) {
    bodies.push_back({robot.bodies[b].parent, inFrame(robot.bodies[b].mass, placed[b])});
  }
  const Eigen::VectorXd mobility = drawnMobility(bodies, dofs);
  for (const auto& [joint, first] : joints) {
    if (!joint->springDamped()) continue;
    const double inertia = 1.0 / mobility.segment(first, joint->kind->degrees_of_freedom).mean();
    if (!std::isfinite(inertia) || inertia <= 0.0) {
      throw DataError(fmt::format("{}: joint: springdamper: found a joint that moves no mass", joint->place));
    }
    const auto [time, ratio] = joint->spring_damper;
    joint->stiffness = inertia / (time * time * ratio * ratio);
    joint->damping = 2.0 * inertia / time;
  }
}

}  // namespace simgap
