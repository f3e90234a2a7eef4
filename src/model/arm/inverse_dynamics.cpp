#include "simgap/model/arm/inverse_dynamics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What a moment of inertia about another point has more: m (c.c 1 - c c^T), Huygens and Steiner.
Matrix3d shiftOf(double mass, const Vector3d& centre) {
  return mass * (centre.squaredNorm() * Matrix3d::Identity() - centre * centre.transpose());
}

}  // namespace

std::span<const char* const> bodyParameterNames() {
  static constexpr std::array<const char*, kBodyParameters> kNames = {"m",    "mc_x", "mc_y", "mc_z", "I_xx",
                                                                      "I_xy", "I_xz", "I_yy", "I_yz", "I_zz"};
  return kNames;
}

BodyParameters parametersOf(const MassProperties& mass) {
  const Matrix3d inertia = mass.inertia + shiftOf(mass.mass, mass.centre_of_mass);
  BodyParameters pi;
  pi << mass.mass, mass.mass * mass.centre_of_mass, inertia(0, 0), inertia(0, 1), inertia(0, 2), inertia(1, 1),
      inertia(1, 2), inertia(2, 2);
  return pi;
}

MassProperties massPropertiesOf(const BodyParameters& pi) {
  MassProperties mass;
  mass.mass = pi[0];
  mass.centre_of_mass = pi.segment<3>(1) / pi[0];
  mass.inertia << pi[4], pi[5], pi[6], pi[5], pi[7], pi[8], pi[6], pi[8], pi[9];
  mass.inertia -= shiftOf(mass.mass, mass.centre_of_mass);
  return mass;
}

InverseDynamics::InverseDynamics(const ArmModel& model) : all_bodies_(model.bodies.size()) {
  std::vector<int> carrier(model.bodies.size(), -1);  // joint that a body hangs on
  for (const Joint& joint : model.joints) {
    if (!joint.hasAxis()) {
      throw ConfigError(fmt::format(
          "joint {}: found a ball, expected joints of one axis: a ball has no single position and torque", joint.name));
    }
    const int index = static_cast<int>(links_.size());
    carrier[joint.child] = index;
    Link link{.parent = joint.parent,
              .child = joint.child,
              .coordinate = static_cast<int>(coordinates_.size()),
              .slides = joint.slides(),
              .ratio = 1.0,
              .offset = 0.0,
              .constant = {},
              .sine = Matrix3d::Zero(),
              .cosine = Matrix3d::Zero(),
              .pivot = joint.parent_position,
              .axis = joint.parent_orientation * joint.axis,
              .child_pivot = joint.child_position,
              .stiffness = joint.spring_stiffness,
              .rest = joint.spring_rest};
    if (!joint.follows()) coordinates_.push_back(index);
    // Rodrigues: Q(q) = 1 + sin q K + (1 - cos q) K^2, K = [axis]x, between the joint's frames on either body.
    const Matrix3d before = joint.parent_orientation.toRotationMatrix();
    const Matrix3d after = joint.child_orientation.toRotationMatrix().transpose();
    const Matrix3d k = cross(joint.axis);
    link.constant = before * after;
    if (!joint.slides()) {
      link.constant += before * k * k * after;
      link.sine = before * k * after;
      link.cosine = -before * k * k * after;
    }
    links_.push_back(link);
  }
  for (std::size_t j = 0; j < links_.size(); ++j) {  // a leader may hang further out than its follower
    const Joint& joint = model.joints[j];
    if (!joint.follows()) continue;
    links_[j].coordinate = links_[joint.leader].coordinate;
    links_[j].ratio = joint.coupling_ratio;
    links_[j].offset = joint.coupling_offset;
  }
  for (int b = 0; b < std::ssize(model.bodies); ++b) {
    if (model.bodies[b].fixed) continue;
    bodies_.push_back(b);
    std::vector<int>& way = ways_.emplace_back();
    for (int j = carrier[b]; j >= 0; j = carrier[links_[j].parent]) way.push_back(j);
  }
}

Eigen::VectorXd InverseDynamics::parametersOf(const ArmModel& model) const {
  Eigen::VectorXd pi(parameters());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Index at = kBodyParameters * static_cast<Index>(b);
    pi.segment<kBodyParameters>(at) = simgap::parametersOf(massProperties(model.bodies[bodies_[b]]));
  }
  return pi;
}

bool InverseDynamics::carries(std::size_t coordinate, std::size_t body) const {
  return std::ranges::any_of(ways_[body], [&](int j) { return links_[j].coordinate == static_cast<int>(coordinate); });
}

InverseDynamics::Workspace InverseDynamics::workspace() const {
  Workspace work;
  work.bodies.resize(all_bodies_);
  work.joints.resize(links_.size());
  return work;
}

void InverseDynamics::move(std::span<const double> position, std::span<const double> velocity,
                           std::span<const double> acceleration, const Vector3d& gravity, Workspace& work) const {
  for (Workspace::Motion& body : work.bodies) body.acceleration = -gravity;  // of what stands: it is held up
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Link& link = links_[j];
    const Workspace::Motion& parent = work.bodies[link.parent];
    Workspace::Motion& child = work.bodies[link.child];
    const double q = link.offset + link.ratio * position[link.coordinate];
    const double dq = link.ratio * velocity[link.coordinate], ddq = link.ratio * acceleration[link.coordinate];
    const Vector3d axis = parent.rotation * link.axis;
    const Vector3d arm = parent.rotation * (link.slides ? Vector3d(link.pivot + q * link.axis) : link.pivot);
    Vector3d pivot_acceleration =
        parent.acceleration + parent.turn_rate.cross(arm) + parent.turn.cross(parent.turn.cross(arm));
    if (link.slides) {
      child.rotation.noalias() = parent.rotation * link.constant;
      child.turn = parent.turn;
      child.turn_rate = parent.turn_rate;
      pivot_acceleration += 2.0 * dq * parent.turn.cross(axis) + ddq * axis;
    } else {
      const Matrix3d turned = link.constant + std::sin(q) * link.sine + std::cos(q) * link.cosine;
      child.rotation.noalias() = parent.rotation * turned;
      child.turn = parent.turn + dq * axis;
      child.turn_rate = parent.turn_rate + ddq * axis + dq * parent.turn.cross(axis);
    }
    const Vector3d pivot = parent.origin + arm, back = -(child.rotation * link.child_pivot);
    child.origin = pivot + back;
    child.acceleration = pivot_acceleration + child.turn_rate.cross(back) + child.turn.cross(child.turn.cross(back));
    work.joints[j] = {pivot, axis};
  }
}

void InverseDynamics::regressor(std::span<const double> position, std::span<const double> velocity,
                                std::span<const double> acceleration, const Vector3d& gravity, Workspace& work,
                                Eigen::Ref<RegressorMatrix> y) const {
  move(position, velocity, acceleration, gravity, work);
  y.setZero();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Workspace::Motion& body = work.bodies[bodies_[b]];
    const Matrix3d to_body = body.rotation.transpose();
    const Vector3d w = to_body * body.turn, dw = to_body * body.turn_rate, a = to_body * body.acceleration;
    for (const int j : ways_[b]) {
      const Link& link = links_[j];
      const Vector3d& axis = work.joints[j].direction;
      // A joint feels s.(n + (o - p) x f) of the force f and the moment n about the body's origin o: d.f + s.n.
      const Vector3d s = to_body * axis;
      const Vector3d d = link.slides ? s : Vector3d(to_body * axis.cross(body.origin - work.joints[j].point));
      double* row = &y(link.coordinate, kBodyParameters * static_cast<Index>(b));
      const double r = link.ratio;
      // f = m a + dw x mc + w x (w x mc)
      row[0] += r * d.dot(a);
      Vector3d moment = d.cross(dw) + w * w.dot(d) - d * w.squaredNorm();
      if (!link.slides) {
        // n = mc x a + I dw + w x I w
        moment += a.cross(s);
        const Vector3d p = s.cross(w);
        row[4] += r * (s.x() * dw.x() + p.x() * w.x());
        row[5] += r * (s.x() * dw.y() + s.y() * dw.x() + p.x() * w.y() + p.y() * w.x());
        row[6] += r * (s.x() * dw.z() + s.z() * dw.x() + p.x() * w.z() + p.z() * w.x());
        row[7] += r * (s.y() * dw.y() + p.y() * w.y());
        row[8] += r * (s.y() * dw.z() + s.z() * dw.y() + p.y() * w.z() + p.z() * w.y());
        row[9] += r * (s.z() * dw.z() + p.z() * w.z());
      }
      for (Index k = 0; k < 3; ++k) row[1 + k] += r * moment[k];
    }
  }
}

double InverseDynamics::springTorque(std::size_t c, double position) const {
  double torque = 0.0;
  for (const Link& link : links_) {
    if (link.coordinate != static_cast<int>(c)) continue;
    torque += link.ratio * link.stiffness * (link.offset + link.ratio * position - link.rest);
  }
  return torque;
}

}  // namespace simgap
