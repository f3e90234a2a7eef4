#include "reality/arm_trajectory.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace simgap::reality {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kBody = 13;  // x, q (w first), v, omega
constexpr int kMotor = 3;  // current, motor velocity, shaft

Matrix3d crossMatrix(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

// What a link weighs, about its own centre.
struct Solid {
  double mass = 0.0;
  Vector3d centre = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();
};

Solid solidOf(const Link& link) {
  Solid solid;
  for (const Part& part : link.parts) {
    solid.mass += part.mass;
    solid.centre += part.mass * part.position;
  }
  solid.centre /= solid.mass;
  for (const Part& part : link.parts) {
    const double along = 0.5 * part.mass * part.radius * part.radius;
    const double across = part.mass * (3.0 * part.radius * part.radius + part.length * part.length) / 12.0;
    const Vector3d way = part.position - solid.centre;
    solid.inertia += across * Matrix3d::Identity() + (along - across) * part.axis * part.axis.transpose() -
                     part.mass * crossMatrix(way) * crossMatrix(way);
  }
  return solid;
}

struct Moving {
  Vector3d x, v, omega;
  Matrix3d rotation;
};

class MovedArm {
 public:
  MovedArm(const Arm& arm, const SmoothDrive& drive) : arm_(arm), drive_(drive) {
    for (const Link& link : arm.links) solids_.push_back(solidOf(link));
    for (const Link& link : arm.links) rows_ += link.joint == Joint::kSpherical ? 3 : 5;
  }

  VectorXd stateAt(const Configuration& q) const {
    VectorXd state = VectorXd::Zero(kBody * links() + kMotor * muscles());
    std::vector<Matrix3d> rotation(arm_.links.size());
    std::vector<Vector3d> origin(arm_.links.size());
    for (int b = 0; b < links(); ++b) {
      const Link& link = arm_.links[b];
      const Matrix3d parent = link.parent == kTorso ? Matrix3d(Matrix3d::Identity()) : rotation[link.parent];
      const Vector3d from = link.parent == kTorso ? Vector3d(Vector3d::Zero()) : origin[link.parent];
      rotation[b] = parent * (link.joint == Joint::kSpherical ? q[b].rotation
                                                              : Matrix3d(Eigen::AngleAxisd(q[b].angle, link.axis)));
      origin[b] = from + parent * link.joint_in_parent - rotation[b] * link.joint_in_child;
      state.segment<3>(kBody * b) = origin[b] + rotation[b] * solids_[b].centre;
      const Quaterniond turn(rotation[b]);
      state.segment<4>(kBody * b + 3) << turn.w(), turn.x(), turn.y(), turn.z();
    }
    return state;
  }

  Configuration configurationAt(const VectorXd& state) const {
    Configuration q(arm_.links.size());
    for (int b = 0; b < links(); ++b) {
      const Link& link = arm_.links[b];
      const Matrix3d parent =
          link.parent == kTorso ? Matrix3d(Matrix3d::Identity()) : body(state, link.parent).rotation;
      q[b].rotation = parent.transpose() * body(state, b).rotation;
      const Quaterniond turn(q[b].rotation);
      q[b].angle = 2.0 * std::atan2(turn.vec().dot(link.axis), turn.w());
    }
    return q;
  }

  double shaft(const VectorXd& state, int muscle) const { return state[kBody * links() + kMotor * muscle + 2]; }
  int muscles() const { return static_cast<int>(arm_.muscles.size()); }

  VectorXd derivative(const VectorXd& state, const std::vector<double>& voltages) const {
    VectorXd change = VectorXd::Zero(state.size());
    std::vector<Moving> bodies;
    for (int b = 0; b < links(); ++b) bodies.push_back(body(state, b));
    VectorXd load = VectorXd::Zero(6 * links());
    for (int b = 0; b < links(); ++b) {
      const Matrix3d inertia = bodies[b].rotation * solids_[b].inertia * bodies[b].rotation.transpose();
      load.segment<3>(6 * b) = solids_[b].mass * arm_.gravity;
      load.segment<3>(6 * b + 3) = -bodies[b].omega.cross(inertia * bodies[b].omega);
      const int parent = arm_.links[b].parent;
      const Vector3d slip = bodies[b].omega - (parent == kTorso ? Vector3d(Vector3d::Zero()) : bodies[parent].omega);
      load.segment<3>(6 * b + 3) -= arm_.links[b].viscous * slip;
      if (parent != kTorso) load.segment<3>(6 * parent + 3) += arm_.links[b].viscous * slip;
    }
    for (int m = 0; m < muscles(); ++m) drive(state, bodies, m, voltages[m], load, change);
    const VectorXd acceleration = solve(bodies, load);
    for (int b = 0; b < links(); ++b) {
      change.segment<3>(kBody * b) = bodies[b].v;
      const Quaterniond turn(state[kBody * b + 3], state[kBody * b + 4], state[kBody * b + 5], state[kBody * b + 6]);
      const Quaterniond spin(0.0, bodies[b].omega.x(), bodies[b].omega.y(), bodies[b].omega.z());
      const Quaterniond rate = spin * turn;
      change.segment<4>(kBody * b + 3) << 0.5 * rate.w(), 0.5 * rate.x(), 0.5 * rate.y(), 0.5 * rate.z();
      change.segment<6>(kBody * b + 7) = acceleration.segment<6>(6 * b);
    }
    return change;
  }

 private:
  int links() const { return static_cast<int>(arm_.links.size()); }

  Moving body(const VectorXd& state, int b) const {
    const Quaterniond turn(state[kBody * b + 3], state[kBody * b + 4], state[kBody * b + 5], state[kBody * b + 6]);
    return {state.segment<3>(kBody * b), state.segment<3>(kBody * b + 7), state.segment<3>(kBody * b + 10),
            turn.normalized().toRotationMatrix()};
  }

  // A point of a link, as seen from its centre, and its velocity.
  void follow(const std::vector<Moving>& bodies, const Attachment& at, Vector3d& arm, Vector3d& point,
              Vector3d& velocity) const {
    if (at.link == kTorso) {
      point = at.point;
      arm = velocity = Vector3d::Zero();
      return;
    }
    const Moving& moving = bodies[at.link];
    arm = moving.rotation * (at.point - solids_[at.link].centre);
    point = moving.x + arm;
    velocity = moving.v + moving.omega.cross(arm);
  }

  void drive(const VectorXd& state, const std::vector<Moving>& bodies, int m, double voltage, VectorXd& load,
             VectorXd& change) const {
    const Muscle& muscle = arm_.muscles[m];
    const int first = kBody * links() + kMotor * m;
    const double current = state[first], speed = state[first + 1], shaft = state[first + 2];
    Vector3d arm_from, from, from_v, arm_to, to, to_v;
    follow(bodies, muscle.from, arm_from, from, from_v);
    follow(bodies, muscle.to, arm_to, to, to_v);
    const double length = (to - from).norm();
    const Vector3d along = (to - from) / length;
    const double stretch = length - muscle.kite_line + muscle.spindle_radius * shaft - muscle.cord_rest;
    const double rate = along.dot(to_v - from_v) + muscle.spindle_radius * speed / drive_.ratio;
    const double force = stretch > 0.0 ? std::max(0.0, muscle.stiffness * stretch + muscle.damping * rate) : 0.0;
    const auto pull = [&](int link, const Vector3d& arm, const Vector3d& f) {
      if (link == kTorso) return;
      load.segment<3>(6 * link) += f;
      load.segment<3>(6 * link + 3) += arm.cross(f);
    };
    pull(muscle.from.link, arm_from, force * along);
    pull(muscle.to.link, arm_to, -force * along);

    const double gain = drive_.ratio * drive_.efficiency;
    change[first] = (voltage - drive_.resistance * current - drive_.back_emf * speed) / drive_.inductance;
    change[first + 1] =
        (gain * drive_.torque_constant * current -
         (gain * drive_.motor_viscous + drive_.gear_viscous / drive_.ratio) * speed - muscle.spindle_radius * force) /
        (gain * drive_.motor_inertia + drive_.gear_inertia / drive_.ratio);
    change[first + 2] = speed / drive_.ratio;
  }

  VectorXd solve(const std::vector<Moving>& bodies, const VectorXd& load) const {
    const int n = 6 * links();
    Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(n + rows_, n + rows_);
    VectorXd right = VectorXd::Zero(n + rows_);
    right.head(n) = load;
    int row = n;
    for (int b = 0; b < links(); ++b) {
      const Moving& child = bodies[b];
      kkt.block<3, 3>(6 * b, 6 * b) = solids_[b].mass * Matrix3d::Identity();
      kkt.block<3, 3>(6 * b + 3, 6 * b + 3) = child.rotation * solids_[b].inertia * child.rotation.transpose();
      const Link& link = arm_.links[b];
      const bool hung = link.parent != kTorso;
      const Moving still{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Matrix3d::Identity()};
      const Moving& parent = hung ? bodies[link.parent] : still;
      const Vector3d own = child.rotation * (link.joint_in_child - solids_[b].centre);
      const Vector3d other =
          parent.rotation * (link.joint_in_parent - (hung ? solids_[link.parent].centre : Vector3d(Vector3d::Zero())));
      // Both bodies' points at the joint accelerate alike.
      kkt.block<3, 3>(row, 6 * b) = Matrix3d::Identity();
      kkt.block<3, 3>(row, 6 * b + 3) = -crossMatrix(own);
      right.segment<3>(row) = -child.omega.cross(child.omega.cross(own));
      if (hung) {
        kkt.block<3, 3>(row, 6 * link.parent) = -Matrix3d::Identity();
        kkt.block<3, 3>(row, 6 * link.parent + 3) = crossMatrix(other);
        right.segment<3>(row) += parent.omega.cross(parent.omega.cross(other));
      }
      row += 3;
      if (link.joint == Joint::kSpherical) continue;
      // They turn against each other about the axis alone.
      const Vector3d across = link.axis.unitOrthogonal();
      for (const Vector3d& in_parent : {across, Vector3d(link.axis.cross(across))}) {
        const Vector3d normal = parent.rotation * in_parent;
        kkt.block<1, 3>(row, 6 * b + 3) = normal.transpose();
        if (hung) kkt.block<1, 3>(row, 6 * link.parent + 3) = -normal.transpose();
        right[row] = -(child.omega - parent.omega).dot(parent.omega.cross(normal));
        ++row;
      }
    }
    kkt.topRightCorner(n, rows_) = -kkt.bottomLeftCorner(rows_, n).transpose();
    return kkt.partialPivLu().solve(right).head(n);
  }

  const Arm& arm_;
  SmoothDrive drive_;
  std::vector<Solid> solids_;
  int rows_ = 0;
};

}  // namespace

std::vector<Configuration> play(const Arm& arm, const SmoothDrive& drive, const std::vector<double>& references,
                                double step, double interval, double end) {
  const MovedArm mechanism(arm, drive);
  VectorXd y = mechanism.stateAt(restPose(arm));
  std::vector<double> voltages(references.size());
  std::vector<Configuration> motion{mechanism.configurationAt(y)};
  const long per_tick = std::lround(drive.tick / step), per_row = std::lround(interval / step);
  const long steps = std::lround(end / step);
  for (long n = 0; n < steps; ++n) {
    if (n % per_tick == 0) {
      for (int m = 0; m < mechanism.muscles(); ++m) {
        voltages[m] = std::clamp(drive.gain * (references[m] - mechanism.shaft(y, m)), -drive.supply, drive.supply);
      }
    }
    const VectorXd k1 = mechanism.derivative(y, voltages);
    const VectorXd k2 = mechanism.derivative(y + 0.5 * step * k1, voltages);
    const VectorXd k3 = mechanism.derivative(y + 0.5 * step * k2, voltages);
    const VectorXd k4 = mechanism.derivative(y + step * k3, voltages);
    y += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    if ((n + 1) % per_row == 0) motion.push_back(mechanism.configurationAt(y));
  }
  return motion;
}

}  // namespace simgap::reality
