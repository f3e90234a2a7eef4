#include "reality/pose_draws.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

#include "reality/arm_placement.h"

namespace simgap::reality {
namespace {

constexpr double kSession = 3600.0;    // [s]
constexpr double kCreepTime = 1200.0;  // [s] of an exponential approach
const double kCapture = 0.3 * M_PI / 180.0;

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * (double(engine_() >> 11) + 0.5) * 0x1.0p-53; }
  double sign() { return uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0; }
  std::size_t below(std::size_t n) { return std::min(n - 1, std::size_t(uniform(0.0, double(n)))); }
  Eigen::Vector3d direction() {
    for (;;) {
      const double z = uniform(-1, 1), y = uniform(-1, 1), x = uniform(-1, 1);
      const Eigen::Vector3d v(x, y, z);
      if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
    }
  }

 private:
  std::mt19937_64 engine_;
};

// Of any hinge. Drawn where it is asked for alone, so that the draws of older seeds stay as they were.
constexpr char kAxis[] = "joint-axis";

// One row per effect and target: the magnitudes that a set of 80 poses can just reveal, on average over arms. Of this
// arm's muscles only a few touch a sphere about a joint they cross in its range of poses.
struct Kind {
  std::string effect, target;
  double low, high;
};

std::vector<Kind> kinds() {
  return {{"muscle-wrap", "muscle9", 0.055, 0.065},
          {"muscle-wrap", "muscle10", 0.032, 0.036},
          {"spindle-coiling", "", 0.026, 0.034},
          {"spindle-coiling", "muscle4", 0.046, 0.06},
          {"spindle-coiling", "muscle10", 0.09, 0.12},
          {"spindle-coiling", "muscle11", 0.07, 0.09},
          {"cord-hardening", "", 0.35, 0.5},
          {"cord-hardening", "muscle10", 1.0, 1.5},
          {"cord-hardening", "muscle11", 1.0, 1.5},
          {"cord-creep", "", 0.0035, 0.005},
          {"cord-creep", "muscle3", 0.006, 0.009},
          {"cord-creep", "muscle10", 0.006, 0.008},
          {"cord-creep", "muscle11", 0.0045, 0.0065},
          {"potentiometer-slip", "muscle2", 0.35, 0.5},
          {"potentiometer-slip", "muscle8", 0.4, 0.55},
          {"potentiometer-slip", "muscle9", 0.3, 0.45},
          {"potentiometer-slip", "muscle10", 0.28, 0.4},
          {"potentiometer-slip", "muscle11", 0.25, 0.35},
          {"gravity-tilt", "", 0.1, 0.15},
          {"payload", "link1", 0.9, 1.2},
          {"payload", "link2", 0.17, 0.22},
          {"passive-joint-torque", "joint1", 0.5, 0.65},
          {"passive-joint-torque", "joint2", 0.45, 0.6},
          {"joint-stiction", "joint1", 0.1, 0.13},
          {"joint-stiction", "joint2", 0.06, 0.08},
          {"marker-frame-offset", "torso", 0.08, 0.12},
          {"marker-frame-offset", "link1", 0.04, 0.06},
          {"marker-frame-offset", "link2", 0.03, 0.045},
          {"joint-centre-offset", "joint1", 0.02, 0.026},
          {"joint-centre-offset", "joint2", 0.025, 0.04},
          {kAxis, "", 0.08, 0.1}};
}

int numberIn(const std::string& target) {
  const std::size_t digits = target.find_first_of("0123456789");
  return digits == std::string::npos ? -1 : std::stoi(target.substr(digits)) - 1;
}

// What a truth does to the poses beyond its statics.
struct Session {
  int creeping = -2;  // muscle, -1: all, -2: none
  double creep = 0.0;
  int slipping = -1;
  double slip = 0.0, slip_time = 0.0;
  std::vector<std::pair<int, Eigen::Vector3d>> turned;  // link, rotation vector of its markers
  std::vector<double> sticking;                         // per link [N m]; 0: anywhere that Coulomb friction holds
};

double nearerEnd(const Arm& arm, const Muscle& muscle, int link) {
  const Link& joint = arm.links[std::size_t(link)];
  const auto distance = [&](const Attachment& end) {
    if (end.link == link) return (end.point - joint.joint_in_child).norm();
    if (end.link == joint.parent) return (end.point - joint.joint_in_parent).norm();
    return 1e9;
  };
  return std::min(distance(muscle.from), distance(muscle.to));
}

std::size_t drawHinge(const Arm& arm, Draws& draws) {
  std::vector<std::size_t> hinges;
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    if (arm.links[i].joint == Joint::kRevolute) hinges.push_back(i);
  }
  return hinges[draws.below(hinges.size())];
}

void hide(HiddenCause& cause, Arm& arm, Session& session, Draws& draws) {
  const int number = numberIn(cause.target);
  const double m = cause.magnitude;
  const auto forMuscles = [&](auto action) {
    for (std::size_t i = 0; i < arm.muscles.size(); ++i) {
      if (number < 0 || number == int(i)) action(arm.muscles[i]);
    }
  };
  if (cause.effect == "muscle-wrap") {
    Muscle& muscle = arm.muscles[std::size_t(number)];
    muscle.wrap_link = number >= 9 ? 1 : 0;  // brachialis and triceps cross the elbow only
    muscle.wrap_radius = std::min(m, 0.97 * nearerEnd(arm, muscle, muscle.wrap_link));
    cause.magnitude = muscle.wrap_radius;
    cause.parameters = {muscle.wrap_radius};
  } else if (cause.effect == "spindle-coiling") {
    forMuscles([&](Muscle& muscle) { muscle.coiling = m * muscle.spindle_radius; });
    cause.parameters = {m};
  } else if (cause.effect == "cord-hardening") {
    forMuscles([&](Muscle& muscle) { muscle.hardening = m; });
    cause.parameters = {m};
  } else if (cause.effect == "cord-creep") {
    session.creeping = number;
    session.creep = m;
  } else if (cause.effect == "potentiometer-slip") {
    session.slipping = number;
    session.slip = draws.sign() * m;
    cause.moment = session.slip_time = draws.uniform(0.3, 0.7) * kSession;
    cause.magnitude = session.slip;
    cause.parameters = {session.slip};
  } else if (cause.effect == "gravity-tilt") {
    const double heading = draws.uniform(0.0, 2.0 * M_PI);
    cause.parameters = {m * std::cos(heading), m * std::sin(heading)};
    arm.gravity = Eigen::AngleAxisd(m, Eigen::Vector3d(std::cos(heading), std::sin(heading), 0.0)) * arm.gravity;
  } else if (cause.effect == "payload") {
    Part load;
    load.mass = m;
    load.position = {0.0, 0.01, -draws.uniform(0.12, 0.22)};
    cause.parameters = {m, load.position.norm()};
    arm.links[std::size_t(number)].parts.push_back(load);
  } else if (cause.effect == "passive-joint-torque") {
    Link& link = arm.links[std::size_t(number)];
    if (link.joint == Joint::kSpherical) {
      link.skin = m;
    } else {
      link.stop = m;
      link.stop_from = draws.uniform(0.5, 0.9);
      cause.parameters = {m, link.stop_from};
    }
  } else if (cause.effect == "joint-stiction") {
    session.sticking[std::size_t(number)] = m;
    cause.parameters = {m};
  } else if (cause.effect == "marker-frame-offset") {
    // A turn of the forearm's markers shows about the elbow's axis only.
    Eigen::Vector3d axis = draws.direction();
    if (cause.target == "link2") axis = (Eigen::Vector3d(3.0 * draws.sign(), 0, 0) + axis).normalized();
    session.turned.push_back({cause.target == "torso" ? kTorso : number, m * axis});
    cause.parameters = {m * axis.x(), m * axis.y(), m * axis.z()};
  } else if (cause.effect == "joint-centre-offset") {
    const Eigen::Vector3d shift = m * draws.direction();
    cause.parameters = {shift.x(), shift.y(), shift.z()};
    arm.links[std::size_t(number)].joint_in_parent += shift;
  } else if (cause.effect == kAxis) {
    const std::size_t hinge = drawHinge(arm, draws);
    cause.target = jointName(int(hinge));
    Eigen::Vector3d& axis = arm.links[hinge].axis;
    Eigen::Index along = 0;
    axis.cwiseAbs().maxCoeff(&along);
    const double heading = draws.uniform(0.0, 2.0 * M_PI);
    cause.parameters = {m * std::cos(heading), m * std::sin(heading)};
    const Eigen::Vector3d tilt = cause.parameters[0] * Eigen::Vector3d::Unit((along + 1) % 3) +
                                 cause.parameters[1] * Eigen::Vector3d::Unit((along + 2) % 3);
    axis = rotationOf<double>(tilt) * axis;
  } else {
    throw std::runtime_error("no such cause: " + cause.effect);
  }
}

Eigen::VectorXd stackedPose(const Arm& arm, const JointTorques& torques) {
  Eigen::VectorXd all(freedoms(arm));
  Eigen::Index first = 0;
  for (const Eigen::VectorXd& torque : torques) {
    all.segment(first, torque.size()) = torque;
    first += torque.size();
  }
  return all;
}

Configuration displacedPose(const Arm& arm, Configuration q, const Eigen::VectorXd& w) {
  int first = 0;
  for (std::size_t i = 0; i < arm.links.size(); first += freedoms(arm.links[i++])) {
    if (arm.links[i].joint == Joint::kSpherical) {
      q[i].rotation = q[i].rotation * rotationOf<double>(w.segment<3>(first));
    } else {
      q[i].angle = std::clamp(q[i].angle + w[first], arm.links[i].lower, arm.links[i].upper);
    }
  }
  return q;
}

// A joint moves only while more torque acts on it than its friction holds, and then as far as that takes it: the shafts
// wind in small steps, and after each the joints creep until every torque is within its ball.
Configuration drag(const Arm& arm, const std::vector<double>& shafts, const std::vector<double>& friction) {
  constexpr int kSteps = 30;
  const int n = freedoms(arm);
  Configuration q = minimise(arm, std::vector<double>(shafts.size(), 0.0), restPose(arm)).configuration;
  for (int step = 1; step <= kSteps; ++step) {
    std::vector<double> now(shafts);
    for (double& shaft : now) shaft *= double(step) / kSteps;
    for (int iteration = 0; iteration < 12; ++iteration) {
      const Eigen::VectorXd torque = stackedPose(arm, jointTorque(arm, now, q));
      Eigen::VectorXd excess = Eigen::VectorXd::Zero(n);
      int first = 0;
      for (std::size_t i = 0; i < arm.links.size(); first += freedoms(arm.links[i++])) {
        const auto part = torque.segment(first, freedoms(arm.links[i]));
        const bool stopped =
            arm.links[i].joint == Joint::kRevolute && ((q[i].angle <= arm.links[i].lower && part[0] < 0.0) ||
                                                       (q[i].angle >= arm.links[i].upper && part[0] > 0.0));
        const double over = part.norm() - friction[i];
        if (over > 0.0 && !stopped) excess.segment(first, part.size()) = over / part.norm() * part;
      }
      if (excess.norm() < 1e-3) break;
      Eigen::MatrixXd stiffness(n, n);
      for (int c = 0; c < n; ++c) {
        const Eigen::VectorXd w = 1e-5 * Eigen::VectorXd::Unit(n, c);
        stiffness.col(c) = (stackedPose(arm, jointTorque(arm, now, displacedPose(arm, q, -w))) -
                            stackedPose(arm, jointTorque(arm, now, displacedPose(arm, q, w)))) /
                           2e-5;
      }
      Eigen::VectorXd move = stiffness.fullPivLu().solve(excess);
      move *= std::min(1.0, 0.15 / std::max(move.lpNorm<Eigen::Infinity>(), 1e-9));
      q = displacedPose(arm, q, move);
    }
  }
  return q;
}

Configuration withMarkers(const Arm& arm, Configuration q, const Session& session) {
  for (const auto& [link, w] : session.turned) {
    const Eigen::Matrix3d turn = rotationOf<double>(w);
    for (std::size_t i = 0; i < arm.links.size(); ++i) {
      const bool child = int(i) == link, parent = arm.links[i].parent == link;
      if (!child && !parent) continue;
      if (arm.links[i].joint == Joint::kSpherical) {
        q[i].rotation =
            child ? Eigen::Matrix3d(q[i].rotation * turn) : Eigen::Matrix3d(turn.transpose() * q[i].rotation);
        continue;
      }
      const Eigen::Matrix3d hinge = rotationOf<double>(arm.links[i].axis * q[i].angle);
      const Eigen::Matrix3d seen = child ? Eigen::Matrix3d(hinge * turn) : Eigen::Matrix3d(turn.transpose() * hinge);
      // The angle about the axis that is nearest to what is seen.
      const Eigen::Vector3d u = arm.links[i].axis.unitOrthogonal(), v = arm.links[i].axis.cross(u);
      q[i].angle = std::atan2(v.dot(seen * u) - u.dot(seen * v), u.dot(seen * u) + v.dot(seen * v));
    }
  }
  return q;
}

TimedPose recordAt(const Arm& truth, const Session& session, const std::vector<double>& shafts, double time,
                   std::uint64_t draw) {
  Arm arm = truth;
  for (std::size_t i = 0; i < arm.muscles.size(); ++i) {
    if (session.creeping == -1 || session.creeping == int(i)) {
      arm.muscles[i].kite_line += session.creep * (1.0 - std::exp(-time / kCreepTime));
    }
  }
  std::vector<double> wound = shafts;
  if (session.slipping >= 0 && time >= session.slip_time) wound[std::size_t(session.slipping)] += session.slip;
  RigOptions options;
  options.capture_sd = kCapture;
  const bool drags = std::ranges::any_of(session.sticking, [](double torque) { return torque > 0.0; });
  RecordedPose recorded;
  if (drags) {
    std::vector<double> friction;
    for (std::size_t i = 0; i < arm.links.size(); ++i) {
      friction.push_back(std::max(session.sticking[i], arm.links[i].coulomb));
    }
    recorded.joints = drag(arm, wound, friction);
    Draws noise(draw);
    const auto normal = [&] {
      return std::sqrt(-2.0 * std::log(noise.uniform(0, 1))) * std::cos(2.0 * M_PI * noise.uniform(0, 1));
    };
    for (JointPose& joint : recorded.joints) {
      const double z = normal(), y = normal(), x = normal();
      joint.rotation *= rotationOf<double>(Eigen::Vector3d(kCapture * x, kCapture * y, kCapture * z));
      joint.angle += kCapture * normal();
    }
  } else {
    recorded = record(arm, wound, options, draw);
  }
  return {time, shafts, withMarkers(arm, recorded.joints, session)};
}

}  // namespace

std::vector<std::string> hiddenEffects() {
  std::vector<std::string> names;
  for (const Kind& kind : kinds()) {
    if (std::ranges::find(names, kind.effect) == names.end()) names.push_back(kind.effect);
  }
  return names;
}

PoseDraw drawPoses(std::uint64_t seed, const PoseDrawOptions& options) {
  Draws draws(seed * 104729 + 7);
  const Rig rig =
      makeRig(options.arm ? *options.arm : referenceArm(), seed + 5000, {.calibration = 0, .validation = 0});
  PoseDraw result{rig.nominal, rig.truth, {}, {}, {}};
  Session session;
  session.sticking.assign(rig.truth.links.size(), 0.0);
  for (int c = 0; c < options.causes; ++c) {
    std::vector<std::string> names = hiddenEffects();
    std::erase(names, kAxis);
    if (c == 0 && !options.effect.empty()) names = {options.effect};
    for (const HiddenCause& other : result.hidden) std::erase(names, other.effect);
    const std::string effect = names[draws.below(names.size())];
    std::vector<Kind> choices;
    for (const Kind& kind : kinds()) {
      if (kind.effect == effect) choices.push_back(kind);
    }
    const Kind& kind = choices[draws.below(choices.size())];
    const double strength = options.weak ? 1.0 : draws.uniform(1.4, 2.6);
    HiddenCause cause{effect, kind.target, strength * draws.uniform(kind.low, kind.high), 0.0};
    // A radius cannot grow beyond the ends of its muscle; strong is then as near to them as the rig lets it be.
    hide(cause, result.truth, session, draws);
    result.hidden.push_back(cause);
  }
  Arm later = options.cured ? rig.truth : result.truth;
  Session later_session = session;
  if (options.cured) {
    later_session = {};
    later_session.sticking.assign(rig.truth.links.size(), 0.0);
  }
  if (options.change) options.change(later);
  const double pause = options.cured || options.change ? kSession : 0.0;
  const std::uint64_t base = 1000000 * (seed + 1);
  for (int p = 0; p < options.poses + options.fresh; ++p) {
    const bool fresh = p >= options.poses;
    const int n = fresh ? options.fresh : options.poses;
    const double time = kSession * double(fresh ? p - options.poses : p) / std::max(1, n - 1);
    const std::size_t commanded = fresh ? std::size_t(p - options.poses) : options.commands.size();
    const std::vector<double> shafts = commanded < options.commands.size()
                                           ? options.commands[commanded]
                                           : randomShafts(result.truth, base + std::uint64_t(p));
    const std::uint64_t draw = base + 500000 + std::uint64_t(p);
    if (fresh) {
      result.fresh.push_back(recordAt(later, later_session, shafts, time + pause, draw));
    } else {
      result.poses.push_back(recordAt(result.truth, session, shafts, time, draw));
    }
  }
  for (int f = 0; f < options.flipped; ++f) {
    TimedPose& pose = result.poses[draws.below(result.poses.size())];
    pose.joints[0].rotation *= rotationOf<double>(Eigen::Vector3d(M_PI / 2 * draws.direction()));
  }
  return result;
}

std::string posesCsv(const Arm& arm, const std::vector<TimedPose>& poses) {
  std::string text = "pose,time_s";
  for (std::size_t m = 0; m < arm.muscles.size(); ++m) text += ",shaft_" + muscleName(int(m)) + "_rad";
  for (std::size_t j = 0; j < arm.links.size(); ++j) {
    const std::string name = jointName(int(j));
    text += arm.links[j].joint == Joint::kSpherical ? "," + name + "_qw," + name + "_qx," + name + "_qy," + name + "_qz"
                                                    : "," + name + "_rad";
  }
  text += "\n";
  char number[40];
  const auto add = [&](double value) {
    std::snprintf(number, sizeof number, ",%.9g", value);
    text += number;
  };
  for (std::size_t p = 0; p < poses.size(); ++p) {
    std::snprintf(number, sizeof number, "p%03zu", p);
    text += number;
    add(poses[p].time);
    for (const double shaft : poses[p].shafts) add(shaft);
    for (std::size_t j = 0; j < arm.links.size(); ++j) {
      if (arm.links[j].joint == Joint::kRevolute) {
        add(poses[p].joints[j].angle);
        continue;
      }
      const Eigen::Quaterniond q(poses[p].joints[j].rotation);
      for (const double value : {q.w(), q.x(), q.y(), q.z()}) add(value);
    }
    text += "\n";
  }
  return text;
}

}  // namespace simgap::reality
