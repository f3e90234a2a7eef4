#include "reality/robot_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reality/robot_draws.h"

namespace simgap::reality {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kRobotTurn = 2.0 * std::numbers::pi;

std::vector<Isometry3d> linkPoses(const Robot& robot, const VectorXd& q) {
  std::vector<Isometry3d> poses;
  for (std::size_t k = 0; k < robot.links.size(); ++k) {
    const RobotLink& link = robot.links[k];
    const Isometry3d parent = link.parent < 0 ? Isometry3d::Identity() : poses[link.parent];
    const double position = q[k];
    Isometry3d motion = Isometry3d::Identity();
    if (link.slides) {
      motion.translation() = position * link.axis;
    } else {
      motion.linear() = AngleAxisd(position, link.axis).toRotationMatrix();
    }
    poses.push_back(parent * link.origin * motion);
  }
  return poses;
}

/// Velocities of a link's centre and of its turning per joint rate, shape (3, links) each.
struct LinkJacobian {
  MatrixXd way, turn;
};

LinkJacobian jacobianOf(const Robot& robot, const std::vector<Isometry3d>& poses, int link) {
  const Index n = std::ssize(robot.links);
  LinkJacobian jacobian{MatrixXd::Zero(3, n), MatrixXd::Zero(3, n)};
  const Vector3d centre = poses[link] * robot.links[link].centre;
  for (int j = link; j >= 0; j = robot.links[j].parent) {
    const Vector3d axis = poses[j].linear() * robot.links[j].axis;
    if (robot.links[j].slides) {
      jacobian.way.col(j) = axis;
    } else {
      jacobian.turn.col(j) = axis;
      jacobian.way.col(j) = axis.cross(centre - poses[j].translation());
    }
  }
  return jacobian;
}

MatrixXd massMatrix(const Robot& robot, const VectorXd& q) {
  const std::vector<Isometry3d> poses = linkPoses(robot, q);
  MatrixXd mass = MatrixXd::Zero(q.size(), q.size());
  for (int k = 0; k < std::ssize(robot.links); ++k) {
    const LinkJacobian j = jacobianOf(robot, poses, k);
    const Matrix3d inertia = poses[k].linear() * robot.links[k].inertia * poses[k].linear().transpose();
    mass += robot.links[k].mass * j.way.transpose() * j.way + j.turn.transpose() * inertia * j.turn;
  }
  return mass;
}

/// What the trajectory of a joint goes along: its own time, which stops now and then.
struct OwnTime {
  double time, rate, rate_change;
};

double smoothStep(double x) { return x * x * x * (10.0 + x * (6.0 * x - 15.0)); }
double smoothStepSlope(double x) { return 30.0 * x * x * (1.0 - x) * (1.0 - x); }

/// Share of a stop at time t, 1 while it lasts, and its rate of change.
std::pair<double, double> stopAt(double t, double begin, double end) {
  constexpr double kRamp = 0.6;  // [s]
  if (t <= begin || t >= end + 2.0 * kRamp) return {0.0, 0.0};
  if (t < begin + kRamp) {
    const double x = (t - begin) / kRamp;
    return {smoothStep(x), smoothStepSlope(x) / kRamp};
  }
  if (t <= end + kRamp) return {1.0, 0.0};
  const double x = (t - end - kRamp) / kRamp;
  return {1.0 - smoothStep(x), -smoothStepSlope(x) / kRamp};
}

std::vector<OwnTime> ownTimes(const RobotRigOptions& options, RobotDraws& draws) {
  constexpr int kFine = 20;  // steps between rows
  std::vector<std::pair<double, double>> stops;
  for (double t = draws.between(2.0, 8.0); options.stops && t < options.duration; t += draws.between(8.0, 16.0)) {
    stops.emplace_back(t, t + draws.between(0.3, 1.5));
  }
  const auto stopped = [&](double t) {
    double share = 0.0, change = 0.0;
    for (const auto& [begin, end] : stops) {
      const auto [s, c] = stopAt(t, begin, end);
      share += s;
      change += c;
    }
    return std::pair(share, change);
  };
  std::vector<OwnTime> times;
  const double step = 1.0 / options.rate / kFine;
  double own = options.start;
  for (int i = 0; i < static_cast<int>(options.duration * options.rate); ++i) {
    const double t = i / options.rate;
    const auto [share, change] = stopped(t);
    times.push_back({own, 1.0 - share, -change});
    for (int k = 0; k < kFine; ++k) {  // Simpson
      const double at = t + k * step;
      own += step * (1.0 - (stopped(at).first + 4.0 * stopped(at + 0.5 * step).first + stopped(at + step).first) / 6.0);
    }
  }
  return times;
}

/// A Fourier series within a joint's limits and speed.
struct JointSeries {
  std::vector<double> sine, cosine;
  double centre = 0.0, base = 1.0;

  std::array<double, 3> at(double t) const {
    std::array<double, 3> value = {centre, 0.0, 0.0};
    for (std::size_t h = 0; h < sine.size(); ++h) {
      const double w = base * static_cast<double>(h + 1), s = std::sin(w * t), c = std::cos(w * t);
      value[0] += sine[h] * s + cosine[h] * c;
      value[1] += w * (sine[h] * c - cosine[h] * s);
      value[2] -= w * w * (sine[h] * s + cosine[h] * c);
    }
    return value;
  }
};

JointSeries drawSeries(const RobotLink& link, const RobotRigOptions& options, RobotDraws& draws) {
  JointSeries series;
  series.base = kRobotTurn / options.period;
  for (int h = 1; h <= options.harmonics; ++h) {
    series.sine.push_back(draws.normal() / h);
    series.cosine.push_back(draws.normal() / h);
  }
  double reach = 0.0, speed = 0.0;
  for (double t = 0.0; t < options.period; t += 0.01) {
    const auto [q, v, a] = series.at(t);
    reach = std::max(reach, std::abs(q));
    speed = std::max(speed, std::abs(v));
  }
  const double top = link.slides ? 0.2 * options.top_speed : options.top_speed;
  const double scale = std::min(0.45 * (link.upper - link.lower) / reach, top / speed);
  for (std::vector<double>* part : {&series.sine, &series.cosine}) {
    for (double& factor : *part) factor *= scale;
  }
  series.centre = 0.5 * (link.lower + link.upper);
  return series;
}

/// \param load  what the bodies ask of all joints
double frictionOf(const RobotLink& link, double v, double left, double own_load, const VectorXd& load) {
  const double by_load = link.load_friction * std::abs(own_load) +
                         (link.coupled_to < 0 ? 0.0 : link.coupled_friction * std::abs(load[link.coupled_to]));
  if (std::abs(v) < 1e-9) return left * (link.coulomb + link.more_static + by_load);
  const double ratio = v / link.stribeck_speed;
  const double dry = link.coulomb + link.more_static / (1.0 + ratio * ratio) + by_load;
  const double bent = std::pow(std::abs(v) / link.top_speed, link.viscous_power - 1.0);
  return dry * (v > 0.0 ? 1.0 : -1.0) + link.viscous * bent * v + link.viscous_forwards * std::abs(v);
}

/// A channel that is written `late` seconds after it was true.
VectorXd writtenLate(const VectorXd& values, double late, double rate) {
  VectorXd written(values.size());
  for (Index i = 0; i < values.size(); ++i) {
    const double at = std::clamp(static_cast<double>(i) - late * rate, 0.0, static_cast<double>(values.size() - 1));
    const auto before = static_cast<Index>(std::floor(at));
    const Index after = std::min(before + 1, values.size() - 1);
    const double share = at - static_cast<double>(before);
    written[i] = (1.0 - share) * values[before] + share * values[after];
  }
  return written;
}

/// Everything that the robot did, shape (rows, links) each.
struct RobotRecord {
  MatrixXd q, v, a, torque;
  MatrixXd warmth;  ///< of each drive [1]: 0 where it begins, about 1 where it moves fast all the time
};

/// The drives warm up by what they rub and cool down to the room.
void warmUp(const RobotRigOptions& options, RobotRecord& record) {
  constexpr double kSlowness = 25.0;  // [s]
  for (Index j = 0; j < record.v.cols(); ++j) {
    const double top = std::max(record.v.col(j).cwiseAbs().maxCoeff(), 1e-9);
    for (Index i = 1; i < record.v.rows(); ++i) {
      const double before = record.warmth(i - 1, j), heat = 2.0 * std::abs(record.v(i, j)) / top;
      record.warmth(i, j) = before + (heat - before) / (kSlowness * options.rate);
    }
  }
}

/// Where a joint turns, friction changes its sign and the controller gives way by as much to the other side: the step
/// of a critically damped loop, with a jump of the acceleration.
void holdBack(const RobotRigOptions& options, Index j, RobotRecord& record) {
  const VectorXd course = record.v.col(j);
  const double w = options.loop;
  for (Index turn = 1; turn < course.size(); ++turn) {
    if (!(course[turn - 1] * course[turn] < 0.0)) continue;
    const double step = -2.0 * options.tracking_error * (course[turn] > 0.0 ? 1.0 : -1.0);
    const double past = course[turn] / (course[turn] - course[turn - 1]);  // of a row, since the turn
    for (Index i = turn; i < course.size(); ++i) {
      const double t = (static_cast<double>(i - turn) + past) / options.rate, fade = std::exp(-w * t);
      record.q(i, j) += step * (1.0 - fade * (1.0 + w * t));
      record.v(i, j) += step * w * w * t * fade;
      record.a(i, j) += step * w * w * (1.0 - w * t) * fade;
    }
  }
}

Robot withLoad(Robot robot) {
  hang(robot.links.back(), robot.load.mass, robot.load.at);
  return robot;
}

RobotRecord moveRobot(const Robot& robot, const RobotRigOptions& options, RobotDraws& draws) {
  const Index n = std::ssize(robot.links), rows = static_cast<Index>(options.duration * options.rate);
  const MatrixXd empty = MatrixXd::Zero(rows, n);
  RobotRecord record{empty, empty, empty, empty, empty};
  for (Index j = 0; j < n; ++j) {
    const JointSeries series = drawSeries(robot.links[j], options, draws);
    const std::vector<OwnTime> own = ownTimes(options, draws);
    for (Index i = 0; i < rows; ++i) {
      const auto [q, v, a] = series.at(own[i].time);
      record.q(i, j) = q;
      record.v(i, j) = v * own[i].rate;
      record.a(i, j) = a * own[i].rate * own[i].rate + v * own[i].rate_change;
    }
  }
  for (Index j = 0; j < n && options.tracking_error > 0.0; ++j) holdBack(options, j, record);
  warmUp(options, record);
  const Robot loaded = robot.load.mass > 0.0 ? withLoad(robot) : robot;
  std::vector<double> left(robot.links.size(), 0.0);
  for (Index i = 0; i < rows; ++i) {
    const double time = static_cast<double>(i) / options.rate;
    const bool carries = time >= robot.load.from && time < robot.load.until;
    const VectorXd load = rigidTorques(carries ? loaded : robot, record.q.row(i).transpose(),
                                       record.v.row(i).transpose(), record.a.row(i).transpose());
    record.torque.row(i) = load.transpose();
    for (Index j = 0; j < n; ++j) {
      const RobotLink& link = robot.links[j];
      const bool rests = std::abs(record.v(i, j)) < 1e-9;
      if (rests && (i == 0 || std::abs(record.v(i - 1, j)) >= 1e-9)) left[j] = draws.between(-1.0, 1.0);
      const double friction =
          (1.0 - link.thins * record.warmth(i, j)) * frictionOf(link, record.v(i, j), left[j], load[j], load);
      record.torque(i, j) += link.rotor * record.a(i, j) + link.offset + friction;
      record.torque(i, j) += link.spring * (record.q(i, j) - link.spring_rest);
      record.torque(i, j) += link.ripple * std::sin(link.ripple_ratio * record.q(i, j) + link.ripple_phase);
    }
  }
  return record;
}

/// What is written of it.
void writeDown(const Robot& robot, const RobotRigOptions& options, RobotRecord& record) {
  for (Index j = 0; j < record.q.cols(); ++j) {
    const RobotLink& link = robot.links[j];
    record.q.col(j) += link.gives * record.torque.col(j);
    record.torque.col(j) = link.effort_gain * record.torque.col(j).array() + link.bias;
    record.q.col(j).array() -= link.zero;
    const double motion_late = link.clock_late + link.position_late, effort_late = link.clock_late + link.effort_late;
    for (MatrixXd* part : {&record.q, &record.v, &record.a}) {
      if (motion_late != 0.0) part->col(j) = writtenLate(part->col(j), motion_late, options.rate);
    }
    if (effort_late != 0.0) record.torque.col(j) = writtenLate(record.torque.col(j), effort_late, options.rate);
  }
}

}  // namespace

VectorXd rigidTorques(const Robot& robot, const VectorXd& q, const VectorXd& v, const VectorXd& a) {
  constexpr double kStep = 1e-5;
  VectorXd torque = massMatrix(robot, q) * a;
  for (Index k = 0; k < q.size(); ++k) {
    VectorXd before = q, after = q;
    before[k] -= kStep;
    after[k] += kStep;
    const MatrixXd slope = (massMatrix(robot, after) - massMatrix(robot, before)) / (2.0 * kStep);
    torque += v[k] * slope * v;
    torque[k] -= 0.5 * v.dot(slope * v);
  }
  const std::vector<Isometry3d> poses = linkPoses(robot, q);
  for (int k = 0; k < std::ssize(robot.links); ++k) {
    torque -= robot.links[k].mass * jacobianOf(robot, poses, k).way.transpose() * robot.gravity;
  }
  const int last = static_cast<int>(robot.links.size()) - 1;
  const Vector3d stretched = poses.back() * robot.links.back().centre - robot.cord.anchor;
  torque += robot.cord.stiffness * jacobianOf(robot, poses, last).way.transpose() * stretched;
  return torque;
}

MatrixXd loggedTorques(const Robot& robot, const RobotRigOptions& options, std::uint64_t draw) {
  RobotDraws draws(draw, 2);
  RobotRecord record = moveRobot(robot, options, draws);
  writeDown(robot, options, record);
  return record.torque;
}

void hang(RobotLink& link, double mass, const Vector3d& point) {
  const double whole = link.mass + mass;
  const Vector3d centre = (link.mass * link.centre + mass * point) / whole;
  const auto steiner = [&](double m, const Vector3d& at) -> Matrix3d {
    const Vector3d r = at - centre;
    return m * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
  };
  link.inertia += steiner(link.mass, link.centre) + steiner(mass, point);
  link.mass = whole;
  link.centre = centre;
}

std::string recordRobot(const Robot& robot, const RobotRigOptions& options, std::uint64_t draw,
                        const std::vector<double>& constants) {
  RobotDraws draws(draw, 2);
  RobotRecord record = moveRobot(robot, options, draws);
  writeDown(robot, options, record);
  const Index n = record.q.cols();
  std::string text = "time_s";
  for (Index j = 0; j < n; ++j) {
    const bool slides = robot.links[j].slides;
    text += fmt::format(",j{}_{}", j + 1, slides ? "m" : "rad");
    if (options.log_velocity) text += fmt::format(",j{}_velocity_{}", j + 1, slides ? "m_s" : "rad_s");
    if (options.current) {
      text += fmt::format(",current_j{}_A", j + 1);
    } else {
      text += fmt::format(",{}_j{}_{}", slides ? "force" : "torque", j + 1, slides ? "N" : "Nm");
    }
    if (robot.links[j].thins > 0.0) text += fmt::format(",j{}_temperature_degC", j + 1);
  }
  const VectorXd sizes = (record.torque.cwiseAbs2().colwise().mean()).cwiseSqrt().transpose() * options.torque_noise;
  VectorXd noise = VectorXd::Zero(n);
  const double fresh = std::sqrt(1.0 - options.correlation * options.correlation);
  for (Index i = 0; i < record.q.rows(); ++i) {
    text += fmt::format("\n{:.4f}", static_cast<double>(i) / options.rate);
    for (Index j = 0; j < n; ++j) {
      const double quantum = options.position_quantum * (robot.links[j].slides ? 0.2 : 1.0);
      noise[j] = options.correlation * noise[j] + fresh * draws.normal();
      const double torque = record.torque(i, j) + sizes[j] * noise[j];
      text += fmt::format(",{:.8g}", quantum > 0.0 ? quantum * std::round(record.q(i, j) / quantum) : record.q(i, j));
      if (options.log_velocity)
        text += fmt::format(",{:.5f}", record.v(i, j) + options.velocity_noise * draws.normal());
      text += fmt::format(",{:.5g}", options.current ? torque / constants[j] : torque);
      if (robot.links[j].thins > 0.0) text += fmt::format(",{:.0f}", 22.0 + 18.0 * record.warmth(i, j));
    }
  }
  return text + "\n";
}

}  // namespace simgap::reality
