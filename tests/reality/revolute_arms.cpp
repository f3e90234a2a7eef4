#include "reality/revolute_arms.h"

namespace simgap::reality {
namespace {

using Eigen::Vector3d;

constexpr double kFriction = 0.02;  // [N m], [N m s]

/// A limb of `length` below its joint.
Link hinge(int parent, const Vector3d& at, const Vector3d& axis, double lower, double upper, double length,
           double mass) {
  Link link;
  link.parent = parent;
  link.joint = Joint::kRevolute;
  link.joint_in_parent = at;
  link.axis = axis;
  link.lower = lower;
  link.upper = upper;
  link.coulomb = link.viscous = kFriction;
  link.parts = {{0.018, length, mass, {0, 0, -length / 2}, Vector3d::UnitZ()}};
  return link;
}

Vector3d inWorld(const Arm& arm, int link, Vector3d point) {
  const Configuration rest = restPose(arm);
  for (; link != kTorso; link = arm.links[std::size_t(link)].parent) {
    const Link& body = arm.links[std::size_t(link)];
    point = body.joint_in_parent +
            Eigen::AngleAxisd(rest[std::size_t(link)].angle, body.axis) * (point - body.joint_in_child);
  }
  return point;
}

/// A muscle whose cord is stretched by `strain` of its rest length where the arm rests.
void add(Arm& arm, const Attachment& from, const Attachment& to, double strain = 0.25, double stiffness = 900.0) {
  Muscle muscle;
  muscle.from = from;
  muscle.to = to;
  muscle.stiffness = stiffness;
  const double length = (inWorld(arm, from.link, from.point) - inWorld(arm, to.link, to.point)).norm();
  muscle.kite_line = length - (1.0 + strain) * muscle.cord_rest;
  arm.muscles.push_back(muscle);
}

}  // namespace

Arm threeHingeArm() {
  const Vector3d x = Vector3d::UnitX();
  Arm arm;
  arm.links = {hinge(kTorso, {0, 0, 0}, x, -1.0, 2.0, 0.06, 0.3),
               hinge(0, {0, 0, -0.06}, Vector3d::UnitZ(), -1.2, 1.2, 0.24, 0.8),
               hinge(1, {0, 0, -0.24}, x, 0.0, 2.4, 0.24, 0.5)};
  add(arm, {kTorso, {0.03, 0.07, 0.05}}, {0, {0.02, 0.03, -0.03}});
  add(arm, {kTorso, {-0.03, -0.07, 0.05}}, {0, {-0.02, -0.03, -0.03}});
  add(arm, {kTorso, {0, 0.09, 0}}, {0, {0, 0.035, -0.05}});
  add(arm, {kTorso, {0, -0.09, 0}}, {0, {0, -0.035, -0.05}});
  add(arm, {0, {0.05, 0.03, -0.02}}, {1, {-0.02, 0.03, -0.06}});
  add(arm, {0, {-0.05, 0.03, -0.02}}, {1, {0.02, 0.03, -0.06}});
  add(arm, {0, {0, -0.05, -0.02}}, {1, {0.03, 0, -0.06}});
  add(arm, {0, {0, -0.05, -0.01}}, {1, {-0.03, 0, -0.08}});
  add(arm, {1, {0, 0.03, -0.08}}, {2, {0, 0.025, -0.05}});
  add(arm, {1, {0, -0.03, -0.08}}, {2, {0, -0.028, 0.03}});
  add(arm, {0, {0, 0.045, 0}}, {2, {0.002, 0.028, -0.06}});
  return arm;
}

Arm planarArm() {
  const Vector3d x = Vector3d::UnitX();
  Arm arm;
  arm.links = {hinge(kTorso, {0, 0, 0}, x, -1.2, 2.2, 0.28, 1.0), hinge(0, {0, 0, -0.28}, x, 0.0, 2.4, 0.24, 0.6)};
  add(arm, {kTorso, {0, 0.08, 0.05}}, {0, {0, 0.03, -0.1}});
  add(arm, {kTorso, {0, -0.08, 0.05}}, {0, {0, -0.03, -0.1}});
  add(arm, {0, {0, 0.025, -0.12}}, {1, {0, 0.025, -0.05}});
  add(arm, {0, {0, -0.025, -0.12}}, {1, {0, -0.028, 0.03}});
  add(arm, {kTorso, {0, 0.05, 0.06}}, {1, {0, 0.03, -0.06}});
  add(arm, {kTorso, {0, -0.05, 0.04}}, {1, {0, -0.03, 0.025}});
  return arm;
}

Arm oneHingeArm() {
  Arm arm;
  arm.links = {hinge(kTorso, {0, 0, 0}, Vector3d::UnitX(), -1.2, 1.2, 0.3, 0.8)};
  add(arm, {kTorso, {0, 0.08, 0.05}}, {0, {0, 0.03, -0.1}});
  add(arm, {kTorso, {0, -0.08, 0.05}}, {0, {0, -0.03, -0.1}});
  return arm;
}

Arm eightHingeArm() {
  Arm arm;
  for (int i = 0; i < 8; ++i) {
    const bool odd = i % 2 == 1;
    arm.links.push_back(
        hinge(i - 1, {0, 0, i > 0 ? -0.08 : 0.0}, odd ? Vector3d::UnitY() : Vector3d::UnitX(), -1.0, 1.0, 0.08, 0.08));
    arm.links.back().coulomb = 0.005;
    const Vector3d aside = odd ? Vector3d::UnitX() : Vector3d::UnitY();
    for (const double side : {1.0, -1.0}) {
      add(arm, {i - 1, Vector3d(0, 0, i > 0 ? -0.02 : 0.05) + side * 0.04 * aside},
          {i, Vector3d(0, 0, -0.05) + side * 0.025 * aside}, 0.3, 1500.0);
    }
  }
  return arm;
}

}  // namespace simgap::reality
