#include "reality/arm_rig.h"

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "reality/arm_placement.h"

namespace simgap::reality {
namespace {

class Noise {
 public:
  explicit Noise(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return (double(engine_() >> 11) + 0.5) * 0x1.0p-53; }
  double normal() { return std::sqrt(-2.0 * std::log(uniform())) * std::cos(2.0 * M_PI * uniform()); }
  Eigen::Vector3d vector() {
    const double x = normal();
    const double y = normal();
    return {x, y, normal()};
  }

 private:
  std::mt19937_64 engine_;
};

Configuration displaced(const Arm& arm, Configuration q, const Eigen::VectorXd& w) {
  int first = 0;
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const Link& link = arm.links[i];
    if (link.joint == Joint::kSpherical) {
      q[i].rotation = q[i].rotation * rotationOf<double>(w.segment<3>(first));
    } else {
      q[i].angle = std::clamp(q[i].angle + w[first], link.lower, link.upper);
    }
    first += freedoms(link);
  }
  return q;
}

Eigen::VectorXd stacked(const Arm& arm, const JointTorques& torques) {
  Eigen::VectorXd all(freedoms(arm));
  Eigen::Index first = 0;
  for (const Eigen::VectorXd& torque : torques) {
    all.segment(first, torque.size()) = torque;
    first += torque.size();
  }
  return all;
}

// Within the ball of torques that the friction of each joint holds, uniformly.
Eigen::VectorXd heldTorque(const Arm& arm, Noise& noise) {
  Eigen::VectorXd held(freedoms(arm));
  int first = 0;
  for (const Link& link : arm.links) {
    if (link.joint == Joint::kSpherical) {
      const Eigen::Vector3d direction = noise.vector().normalized();
      held.segment<3>(first) = link.coulomb * std::cbrt(noise.uniform()) * direction;
    } else {
      held[first] = link.coulomb * (2.0 * noise.uniform() - 1.0);
    }
    first += freedoms(link);
  }
  return held;
}

// Where the torque of gravity and muscles is the one that friction holds: Newton with differences of the torque.
Configuration stuck(const Arm& arm, const std::vector<double>& shafts, Configuration q, const Eigen::VectorXd& held) {
  const int n = freedoms(arm);
  for (int iteration = 0; iteration < 3; ++iteration) {
    Eigen::MatrixXd slope(n, n);
    for (int c = 0; c < n; ++c) {
      const Eigen::VectorXd w = 1e-5 * Eigen::VectorXd::Unit(n, c);
      slope.col(c) = (stacked(arm, jointTorque(arm, shafts, displaced(arm, q, w))) -
                      stacked(arm, jointTorque(arm, shafts, displaced(arm, q, -w)))) /
                     2e-5;
    }
    Eigen::VectorXd missing = held - stacked(arm, jointTorque(arm, shafts, q));
    int first = 0;
    for (std::size_t i = 0; i < arm.links.size(); ++i) {
      const Link& link = arm.links[i];
      // A joint pressed against its stop stays there.
      if (link.joint == Joint::kRevolute && (q[i].angle <= link.lower + 1e-9 || q[i].angle >= link.upper - 1e-9)) {
        missing[first] = 0.0;
        slope.row(first).setZero();
        slope.col(first).setZero();
        slope(first, first) = 1.0;
      }
      first += freedoms(link);
    }
    const Eigen::VectorXd step = slope.fullPivLu().solve(missing);
    if (step.lpNorm<Eigen::Infinity>() > 0.2) return q;  // hardly any stiffness: friction would not tell where it stops
    q = displaced(arm, q, step);
  }
  return q;
}

Arm drawTruth(const Arm& nominal, const RigOptions& options, Noise& noise) {
  Arm truth = nominal;
  for (Muscle& muscle : truth.muscles) {
    muscle.from.point += options.proximal * noise.vector();
    muscle.to.point += options.distal * noise.vector();
    muscle.kite_line += options.kite_line * noise.normal();
    muscle.stiffness *= std::exp(options.stiffness * noise.normal());
    muscle.spindle_radius = std::clamp(muscle.spindle_radius * std::exp(options.radius * noise.normal()), 5e-3, 1e-2);
    muscle.coiling = options.coiling;
    muscle.hardening = options.hardening;
  }
  return truth;
}

}  // namespace

RecordedPose record(const Arm& truth, const std::vector<double>& shafts, const RigOptions& options,
                    std::uint64_t draw) {
  Noise noise(draw);
  RecordedPose pose{shafts, followFromRest(truth, shafts).configuration};
  const Eigen::VectorXd held = heldTorque(truth, noise);
  if (options.friction) pose.joints = stuck(truth, shafts, pose.joints, held);
  for (JointPose& joint : pose.joints) {
    joint.rotation = joint.rotation * rotationOf<double>(options.capture_sd * noise.vector());
    joint.angle += options.capture_sd * noise.normal();
  }
  return pose;
}

Rig makeRig(std::uint64_t seed, const RigOptions& options) { return makeRig(referenceArm(), seed, options); }

Rig makeRig(const Arm& nominal, std::uint64_t seed, const RigOptions& options) {
  Noise noise(seed * 7919 + 17);
  Rig rig;
  rig.nominal = nominal;
  rig.truth = drawTruth(rig.nominal, options, noise);
  const std::uint64_t base = 100000 * (seed + 1);
  for (int p = 0; p < options.calibration; ++p) {
    const std::vector<double> shafts = randomShafts(rig.truth, base + std::uint64_t(p));
    auto& repeats = rig.calibration.emplace_back();
    for (int r = 0; r < options.repeats; ++r) {
      repeats.push_back(record(rig.truth, shafts, options, base + std::uint64_t(1000 * (r + 1) + p)));
      if (p >= options.flipped) continue;
      repeats.back().joints[0].rotation *= rotationOf<double>(Eigen::Vector3d(M_PI / 2 * noise.vector().normalized()));
    }
  }
  for (int p = 0; p < options.validation; ++p) {
    const std::vector<double> shafts = randomShafts(rig.truth, base + std::uint64_t(50000 + p));
    rig.validation.push_back(record(rig.truth, shafts, options, base + std::uint64_t(60000 + p)));
  }
  return rig;
}

}  // namespace simgap::reality
