#include "reality/arm_motion.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "simgap/core/random.h"

namespace simgap::reality {
namespace {

constexpr double kStep = 2.5e-4;  // [s] of the joints
constexpr int kSubsteps = 4;      // of the drives within it
constexpr int kTick = 8;          // steps per period of the controllers: 500 Hz
using Matrix3X = Eigen::Matrix<double, 3, Eigen::Dynamic>;

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d s;
  s << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return s;
}

Eigen::Matrix3d turn(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
}

/// A cylinder's inertia about its centre, in the link's frame.
Eigen::Matrix3d inertiaOf(const Part& part) {
  const double across = part.mass * (3.0 * part.radius * part.radius + part.length * part.length) / 12.0;
  const double along = 0.5 * part.mass * part.radius * part.radius;
  return across * Eigen::Matrix3d::Identity() + (along - across) * part.axis * part.axis.transpose();
}

/// Where a link is, how it moves with the generalised velocities, and its acceleration when these stay as they are.
struct LinkMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Matrix3X spin, drift;  // Jacobians of angular velocity and of the origin's velocity, world
  Eigen::Vector3d w = Eigen::Vector3d::Zero(), alpha = Eigen::Vector3d::Zero(), a = Eigen::Vector3d::Zero();
};

class Simulation {
 public:
  Simulation(const MovingArm& arm, double gain)
      : arm_(arm.arm), drives_(arm.drives), hidden_(arm.hidden), gain_(gain), yielded_(arm.arm.muscles.size(), 0.0) {
    for (const Link& link : arm_.links) {
      first_.push_back(dofs_);
      dofs_ += link.joint == Joint::kSpherical ? 3 : 1;
    }
    v_ = Eigen::VectorXd::Zero(dofs_);
    const std::size_t muscles = arm_.muscles.size();
    shaft_.assign(muscles, 0.0);
    speed_ = current_ = voltage_ = force_ = shaft_;
    pose_ = restPose(arm_);
    pose(arm_);
  }

  void place(const std::vector<double>& shafts) {
    shaft_ = shafts;
    pose_ = followFromRest(arm_, shafts).configuration;
    pose(arm_);
  }
  void setVoltages(const std::vector<double>& voltages) { voltage_ = voltages; }
  void control(const std::vector<double>& setpoints) {
    for (std::size_t m = 0; m < shaft_.size(); ++m) {
      const double gain = gain_ * (hidden_.gains.empty() ? 1.0 : hidden_.gains[m]);
      voltage_[m] = std::clamp(gain * (setpoints[m] - shaft_[m]), -drives_[m].supply, drives_[m].supply);
    }
  }
  void step() {
    const Eigen::VectorXd torque = pull();
    sag();
    for (std::size_t m = 0; m < shaft_.size(); ++m) {
      for (int i = 0; i < kSubsteps; ++i) drive(m, kStep / kSubsteps);
    }
    Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(dofs_, dofs_);
    Eigen::VectorXd rest = torque;
    addBodies(mass, rest);
    const Eigen::MatrixXd damped = withViscous(mass);
    v_ = damped.ldlt().solve(mass * v_ + kStep * rest);
    stopJoints(damped.inverse());
    move();
    pose(arm_);
  }
  const Configuration& joints() const { return pose_; }
  const std::vector<double>& shafts() const { return shaft_; }
  const std::vector<double>& currents() const { return current_; }

 private:
  const LinkMotion& at(int link) const { return link == kTorso ? ground_ : links_[link]; }

  void pose(const Arm& arm) {
    ground_.spin = ground_.drift = Matrix3X::Zero(3, dofs_);
    links_.resize(arm.links.size());
    for (std::size_t l = 0; l < arm.links.size(); ++l) {
      const Link& link = arm.links[l];
      const LinkMotion& parent = at(link.parent);
      LinkMotion& child = links_[l];
      const bool ball = link.joint == Joint::kSpherical;
      child.rotation = parent.rotation * (ball ? pose_[l].rotation : turn(link.axis * pose_[l].angle));
      child.spin = parent.spin;
      Eigen::Vector3d relative;
      if (ball) {
        child.spin.middleCols(first_[l], 3) += child.rotation;
        relative = child.rotation * v_.segment<3>(first_[l]);
      } else {
        child.spin.col(first_[l]) += child.rotation * link.axis;
        relative = child.rotation * link.axis * v_[first_[l]];
      }
      child.w = parent.w + relative;
      child.alpha = parent.alpha + parent.w.cross(relative);  // d(relative)/dt = w_child x relative
      const Eigen::Vector3d down = parent.rotation * link.joint_in_parent, up = child.rotation * link.joint_in_child;
      child.origin = parent.origin + down - up;
      child.drift = parent.drift - skew(down) * parent.spin + skew(up) * child.spin;
      child.a = parent.a + parent.alpha.cross(down) + parent.w.cross(parent.w.cross(down)) - child.alpha.cross(up) -
                child.w.cross(child.w.cross(up));
    }
  }

  void addBodies(Eigen::MatrixXd& mass, Eigen::VectorXd& rest) const {
    for (std::size_t l = 0; l < links_.size(); ++l) {
      const LinkMotion& link = links_[l];
      for (const Part& part : arm_.links[l].parts) {
        const Eigen::Vector3d arm = link.rotation * part.position;
        const Matrix3X velocity = link.drift - skew(arm) * link.spin;
        const Eigen::Vector3d acceleration = link.a + link.alpha.cross(arm) + link.w.cross(link.w.cross(arm));
        const Eigen::Matrix3d inertia = link.rotation * inertiaOf(part) * link.rotation.transpose();
        mass += part.mass * velocity.transpose() * velocity + link.spin.transpose() * inertia * link.spin;
        rest += velocity.transpose() * (part.mass * (arm_.gravity - acceleration));
        rest -= link.spin.transpose() * (inertia * link.alpha + link.w.cross(inertia * link.w));
      }
    }
  }

  /// The muscles' forces as generalised torques.
  Eigen::VectorXd pull() {
    Eigen::VectorXd torque = Eigen::VectorXd::Zero(dofs_);
    for (std::size_t m = 0; m < arm_.muscles.size(); ++m) {
      const Muscle& muscle = arm_.muscles[m];
      const auto point = [&](const Attachment& end, Matrix3X& jacobian) {
        const LinkMotion& link = at(end.link);
        const Eigen::Vector3d arm = link.rotation * end.point;
        jacobian = link.drift - skew(arm) * link.spin;
        return Eigen::Vector3d(link.origin + arm);
      };
      Matrix3X from, to;
      const Eigen::Vector3d start = point(muscle.from, from), line = point(muscle.to, to) - start;
      const double length = line.norm();
      const Eigen::RowVectorXd slope = (line / length).transpose() * (to - from);
      const double expansion = length - muscle.kite_line + muscle.spindle_radius * shaft_[m] - muscle.cord_rest;
      const double rate = slope.dot(v_) + muscle.spindle_radius * speed_[m] / drives_[m].ratio;
      const double stretched = std::max(0.0, expansion);
      if (time_ == 0) yielded_[m] = stretched;
      yielded_[m] += kStep / hidden_.relaxing_time * (stretched - yielded_[m]);
      const double branch = hidden_.relaxing_share * muscle.stiffness * (stretched - yielded_[m]);
      force_[m] = expansion > 0.0 ? std::max(0.0, muscle.stiffness * expansion + branch + muscle.damping * rate) : 0.0;
      const double slip = slope.dot(v_), share = hidden_.guide_loss * slip / std::hypot(slip, hidden_.guide_creep);
      torque -= (1.0 + share) * force_[m] * slope.transpose();
    }
    ++time_;
    if (hidden_.elbow_drag) torque[dofs_ - 1] += hidden_.elbow_drag(pose_.back().angle, v_[dofs_ - 1]);
    return torque;
  }

  /// The supply's voltage as a share of what it is without load.
  void sag() {
    double power = 0.0;
    for (std::size_t m = 0; m < voltage_.size(); ++m) power += supplied_ * voltage_[m] * current_[m];
    const double full = drives_.front().supply;
    const double now = full * supplied_, settled = full - hidden_.supply_resistance * power / now;
    supplied_ = std::clamp((now + kStep / hidden_.supply_time * (settled - now)) / full, 0.1, 1.5);
  }

  void drive(std::size_t m, double dt) {
    const DriveTruth& d = drives_[m];
    const bool returning = current_[m] * speed_[m] < 0.0;
    const double gain = d.ratio * d.efficiency * (returning ? hidden_.returned_efficiency : 1.0);
    const double inertia = gain * d.inertia + d.gear_inertia / d.ratio;
    const double viscous = gain * d.viscous + d.gear_viscous / d.ratio;
    const double dry = gain * d.coulomb + d.gear_coulomb;
    current_[m] = (current_[m] + dt / d.inductance * (supplied_ * voltage_[m] - d.back_emf * speed_[m])) /
                  (1.0 + dt * d.resistance / d.inductance);
    current_[m] = std::clamp(current_[m], -hidden_.current_limit, hidden_.current_limit);
    const double push = gain * d.torque_constant * current_[m] - force_[m] * arm_.muscles[m].spindle_radius;
    const double free = (speed_[m] + dt / inertia * push) / (1.0 + dt * viscous / inertia);
    const double most = dt * dry / inertia;  // speed that friction can take away
    speed_[m] = std::abs(free) <= most ? 0.0 : free - std::copysign(most, free);
    shaft_[m] += dt * speed_[m] / d.ratio;
  }

  Eigen::MatrixXd withViscous(Eigen::MatrixXd mass) const {
    for (std::size_t l = 0; l < arm_.links.size(); ++l) {
      const int n = arm_.links[l].joint == Joint::kSpherical ? 3 : 1;
      for (int i = 0; i < n; ++i) mass(first_[l] + i, first_[l] + i) += kStep * arm_.links[l].viscous;
    }
    return mass;
  }

  /// Coulomb friction and stops as impulses, joint after joint until nothing changes.
  void stopJoints(const Eigen::MatrixXd& mobility) {
    Eigen::VectorXd friction = Eigen::VectorXd::Zero(dofs_), stop = Eigen::VectorXd::Zero(dofs_);
    for (int sweep = 0; sweep < 200; ++sweep) {
      double change = 0.0;
      for (std::size_t l = 0; l < arm_.links.size(); ++l) {
        const Link& link = arm_.links[l];
        const int n = link.joint == Joint::kSpherical ? 3 : 1, at = first_[l];
        // Projected gradient with the block's largest mobility: converges to the impulse of least energy in the ball.
        const Eigen::MatrixXd block = mobility.block(at, at, n, n);
        Eigen::VectorXd next = friction.segment(at, n) - v_.segment(at, n) / block.trace();
        const double most = kStep * link.coulomb;
        if (next.norm() > most) next *= most / next.norm();
        change = std::max(change, apply(mobility, at, next - friction.segment(at, n)));
        friction.segment(at, n) = next;
        if (n > 1) continue;
        const double lowest = (link.lower - pose_[l].angle) / kStep, highest = (link.upper - pose_[l].angle) / kStep;
        const double free = v_[at] - mobility(at, at) * stop[at];
        const double wanted = (std::clamp(free, lowest, highest) - free) / mobility(at, at);
        change = std::max(change, apply(mobility, at, Eigen::VectorXd::Constant(1, wanted - stop[at])));
        stop[at] = wanted;
      }
      if (change < 1e-10) return;
    }
  }
  double apply(const Eigen::MatrixXd& mobility, int at, const Eigen::VectorXd& impulse) {
    const Eigen::VectorXd change = mobility.middleCols(at, impulse.size()) * impulse;
    v_ += change;
    return change.lpNorm<Eigen::Infinity>();
  }

  void move() {
    for (std::size_t l = 0; l < arm_.links.size(); ++l) {
      if (arm_.links[l].joint == Joint::kSpherical) {
        const Eigen::Quaterniond q(pose_[l].rotation * turn(kStep * v_.segment<3>(first_[l])));
        pose_[l].rotation = q.normalized().toRotationMatrix();
      } else {
        pose_[l].angle += kStep * v_[first_[l]];
      }
    }
  }

  Arm arm_;
  std::vector<DriveTruth> drives_;
  HiddenCauses hidden_;
  double gain_, supplied_ = 1.0;
  long time_ = 0;  // steps
  std::vector<double> yielded_;
  int dofs_ = 0;
  std::vector<int> first_;
  Eigen::VectorXd v_;
  Configuration pose_;
  std::vector<LinkMotion> links_;
  LinkMotion ground_;
  std::vector<double> shaft_, speed_, current_, voltage_, force_;
};

/// What the capture makes of a configuration.
Configuration seen(const Arm& arm, Configuration joints, double sd, const CounterRandom& random, std::uint32_t frame) {
  for (std::uint32_t l = 0; l < joints.size(); ++l) {
    const auto a = random.normalPair({frame, l, 0, 1}), b = random.normalPair({frame, l, 1, 1});
    if (arm.links[l].joint == Joint::kSpherical) {
      joints[l].rotation = joints[l].rotation * turn(sd * Eigen::Vector3d(a[0], a[1], b[0]));
    } else {
      joints[l].angle += sd * a[0];
    }
  }
  return joints;
}

}  // namespace

MotionLog recordMotion(const MovingArm& arm, const Setpoints& setpoints, const MotionRigOptions& options,
                       std::uint64_t draw) {
  const CounterRandom random(draw);
  Simulation simulation(arm, options.gain);
  const bool by_voltage = !options.voltages_from.empty();
  simulation.place(by_voltage ? options.voltages_from : setpoints(0.0));
  MotionLog log;
  if (by_voltage) log.command = "voltage_{}_V";
  const long settle = std::lround(options.settle / kStep / kTick) * kTick;
  const long end = std::lround(options.duration / kStep);
  double next_row = 0.0, next_frame = 0.004;  // the capture begins somewhere
  for (long i = -settle; i <= end; ++i) {
    const double time = static_cast<double>(i) * kStep;
    // A row is logged before the tick of its time; commands are held from row to row.
    if (i >= 0 && time >= next_row - 1e-9) {
      const auto row = static_cast<std::uint32_t>(log.times.size());
      log.times.push_back(next_row);
      log.setpoints.push_back(setpoints(next_row));
      log.shafts.push_back(simulation.shafts());
      log.currents.push_back(simulation.currents());
      for (std::uint32_t m = 0; m < arm.drives.size(); ++m) {
        const auto noise = random.normalPair({row, m, 0, 2});
        log.shafts.back()[m] += options.shaft_sd * noise[0];
        log.currents.back()[m] += options.current_sd * noise[1];
      }
      next_row = static_cast<double>(log.times.size()) / options.muscle_rate;
    }
    if (i >= 0 && time >= next_frame + options.capture_delay - 1e-9) {
      const auto frame = static_cast<std::uint32_t>(log.frames.size());
      log.frame_times.push_back(time - options.capture_delay);
      log.frames.push_back(seen(arm.arm, simulation.joints(), options.capture_sd, random, frame));
      next_frame += 1.0 / options.capture_rate;
    }
    if (i % kTick == 0) {
      std::vector<double> commands = i < 0 ? setpoints(0.0) : log.setpoints.back();
      if (i >= 0 && arm.hidden.command_delay > 0.0) {  // the last row that has arrived
        const double late = time - arm.hidden.command_delay;
        const auto row = static_cast<std::size_t>(std::max(0.0, std::floor(late * options.muscle_rate + 1e-9)));
        commands = late < 0.0 ? setpoints(0.0) : log.setpoints[std::min(row, log.setpoints.size() - 1)];
      }
      by_voltage ? simulation.setVoltages(commands) : simulation.control(commands);
    }
    simulation.step();
  }
  return log;
}

std::string musclesCsv(const MotionLog& log) {
  std::string text = "time_s";
  const std::size_t muscles = log.setpoints.front().size();
  for (const char* name : {log.command, "shaft_{}_rad", "current_{}_A"}) {
    for (std::size_t m = 0; m < muscles; ++m) {
      text += "," + fmt::format(fmt::runtime(name), muscleName(static_cast<int>(m)));
    }
  }
  text += "\n";
  for (std::size_t row = 0; row < log.times.size(); ++row) {
    text += fmt::format("{}", log.times[row]);
    for (const auto* channel : {&log.setpoints, &log.shafts, &log.currents}) {
      for (const double value : (*channel)[row]) text += fmt::format(",{:.9g}", value);
    }
    text += "\n";
  }
  return text;
}

std::string jointsCsv(const MotionLog& log, const Arm& arm) {
  std::string text = "time_s";
  for (std::size_t l = 0; l < arm.links.size(); ++l) {
    const std::string name = jointName(static_cast<int>(l));
    text += arm.links[l].joint == Joint::kSpherical ? fmt::format(",{0}_qw,{0}_qx,{0}_qy,{0}_qz", name)
                                                    : fmt::format(",{}_rad", name);
  }
  text += "\n";
  for (std::size_t f = 0; f < log.frames.size(); ++f) {
    text += fmt::format("{:.9g}", log.frame_times[f]);
    for (std::size_t l = 0; l < arm.links.size(); ++l) {
      if (arm.links[l].joint == Joint::kSpherical) {
        const Eigen::Quaterniond q(log.frames[f][l].rotation);
        text += fmt::format(",{:.12g},{:.12g},{:.12g},{:.12g}", q.w(), q.x(), q.y(), q.z());
      } else {
        text += fmt::format(",{:.12g}", log.frames[f][l].angle);
      }
    }
    text += "\n";
  }
  return text;
}

}  // namespace simgap::reality
