#include "reality/arm_statics.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>

#include "reality/arm_placement.h"

namespace simgap::reality {
namespace {

using Complex = std::complex<double>;

constexpr double kImaginaryStep = 1e-30;     // no rounding error at any size; its square must not underflow
constexpr double kRealStep = 1e-5;           // of the central difference: truncation and rounding both near 1e-10
constexpr double kTolerance = 1e-10;         // [N m]; rounding leaves about 1e-14
constexpr double kLargestRotation = 0.15;    // of one Newton step [rad]: stay in the valley the start lies in
constexpr double kSmallestCurvature = 1e-3;  // [N m/rad]: directions without stiffness must not give endless steps

// ---------------------------------------------------------------------------------------------- energy

struct Problem {
  const Arm& arm;
  std::span<const double> shafts;
};

template <typename Scalar>
Scalar energy(const Problem& problem, const Configuration& q, const Displacement<Scalar>& w) {
  const Placement<Scalar> placement(problem.arm, q, w);
  const Vector3<Scalar> gravity = problem.arm.gravity.cast<Scalar>();
  Scalar sum = 0.0;
  for (std::size_t i = 0; i < problem.arm.links.size(); ++i) {
    for (const Part& part : problem.arm.links[i].parts) {
      sum -= part.mass * productSum<Scalar>(gravity, placement.at({int(i), part.position}));
    }
  }
  int first = 0;
  for (std::size_t i = 0; i < problem.arm.links.size(); first += freedoms(problem.arm.links[i++])) {
    const Link& link = problem.arm.links[i];
    if (link.joint == Joint::kSpherical && link.skin != 0.0) {
      const Matrix3<Scalar> turn =
          q[i].rotation.template cast<Scalar>() * rotationOf<Scalar>(w.template segment<3>(first));
      sum += 0.5 * link.skin * (3.0 - turn.trace());
    }
    if (link.joint == Joint::kRevolute && link.stop != 0.0) {
      const Scalar beyond = q[i].angle + w[first] - link.stop_from;
      if (std::real(beyond) > 0.0) sum += 0.5 * link.stop * beyond * beyond;
    }
  }
  for (std::size_t i = 0; i < problem.arm.muscles.size(); ++i) {
    const Scalar expansion = cordExpansion(problem.arm.muscles[i], problem.arm, problem.shafts[i], placement);
    if (std::real(expansion) <= 0.0) continue;
    const Muscle& muscle = problem.arm.muscles[i];
    const Scalar strain = expansion / muscle.cord_rest;
    sum += 0.5 * muscle.stiffness * expansion * expansion * (1.0 + 0.5 * muscle.hardening * strain * strain);
  }
  return sum;
}

double energy(const Problem& problem, const Configuration& q) {
  return energy<double>(problem, q, Eigen::VectorXd::Zero(freedoms(problem.arm)));
}

Eigen::VectorXd gradient(const Problem& problem, const Configuration& q) {
  const int n = freedoms(problem.arm);
  Displacement<Complex> w = Displacement<Complex>::Zero(n);
  Eigen::VectorXd result(n);
  for (int i = 0; i < n; ++i) {
    w[i] = Complex(0.0, kImaginaryStep);
    result[i] = energy(problem, q, w).imag() / kImaginaryStep;
    w[i] = 0.0;
  }
  return result;
}

Eigen::MatrixXd hessian(const Problem& problem, const Configuration& q) {
  const int n = freedoms(problem.arm);
  Eigen::MatrixXd result(n, n);
  Displacement<Complex> w = Displacement<Complex>::Zero(n);
  const auto slope = [&](int along, int moved, double step) {
    w[moved] += step;
    w[along] += Complex(0.0, kImaginaryStep);
    const double value = energy(problem, q, w).imag() / kImaginaryStep;
    w[moved] = w[along] = 0.0;
    return value;
  };
  for (int i = 0; i < n; ++i) {
    for (int j = i; j < n; ++j) {
      result(i, j) = (slope(i, j, kRealStep) - slope(i, j, -kRealStep)) / (2.0 * kRealStep);
      result(j, i) = result(i, j);
    }
  }
  return result;
}

// ---------------------------------------------------------------------------------------------- minimum

// The configuration and the box of its coordinates, as displacements from it: 0 on a side means at that stop.
struct Box {
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;

  Box(const Arm& arm, const Configuration& q) {
    lower = Eigen::VectorXd::Constant(freedoms(arm), -std::numeric_limits<double>::infinity());
    upper = -lower;
    int first = 0;
    for (std::size_t i = 0; i < arm.links.size(); first += freedoms(arm.links[i++])) {
      if (arm.links[i].joint != Joint::kRevolute) continue;
      lower[first] = arm.links[i].lower - q[i].angle;
      upper[first] = arm.links[i].upper - q[i].angle;
    }
  }
  // True when moving coordinate i in the direction of `sign` would leave the box.
  bool blocks(int i, double sign) const { return sign < 0.0 ? lower[i] >= 0.0 : sign > 0.0 && upper[i] <= 0.0; }
};

Configuration moved(const Arm& arm, const Configuration& q, const Eigen::VectorXd& w) {
  Configuration result = q;
  int first = 0;
  for (std::size_t i = 0; i < arm.links.size(); first += freedoms(arm.links[i++])) {
    if (arm.links[i].joint == Joint::kSpherical) {
      const Eigen::Matrix3d product = q[i].rotation * rotationOf<double>(w.segment<3>(first));
      result[i].rotation = Eigen::Quaterniond(product).normalized().toRotationMatrix();
    } else {
      // The clamp puts a joint that was to reach its stop exactly onto it.
      result[i].angle = std::clamp(q[i].angle + w[first], arm.links[i].lower, arm.links[i].upper);
      if (std::abs(result[i].angle - arm.links[i].lower) < 1e-14) result[i].angle = arm.links[i].lower;
      if (std::abs(result[i].angle - arm.links[i].upper) < 1e-14) result[i].angle = arm.links[i].upper;
    }
  }
  return result;
}

std::vector<int> freeCoordinates(const Box& box, const Eigen::VectorXd& slope) {
  std::vector<int> result;
  for (int i = 0; i < slope.size(); ++i) {
    if (!box.blocks(i, -slope[i])) result.push_back(i);
  }
  return result;
}

// Newton's step in the free coordinates with |curvature|, so that it goes downhill from a saddle too. A coordinate at
// its stop that the others would drag through it is held as well; what remains may be followed for a positive length.
Eigen::VectorXd newtonStep(const Box& box, std::vector<int> free, const Eigen::VectorXd& slope,
                           const Eigen::MatrixXd& curvature) {
  while (!free.empty()) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(curvature(free, free));
    const Eigen::VectorXd stiffness = eigen.eigenvalues().cwiseAbs().cwiseMax(kSmallestCurvature);
    const Eigen::VectorXd reduced =
        -(eigen.eigenvectors() * (eigen.eigenvectors().transpose() * slope(free)).cwiseQuotient(stiffness));
    Eigen::VectorXd step = Eigen::VectorXd::Zero(slope.size());
    step(free) = reduced;
    const auto blocked = [&](int i) { return box.blocks(i, step[i]); };
    if (std::erase_if(free, blocked) == 0) return step;
  }
  return Eigen::VectorXd::Zero(slope.size());
}

// The longest part of the step that keeps inside the box and turns no joint too far.
double longestPart(const Box& box, const Eigen::VectorXd& step) {
  double part = std::min(1.0, kLargestRotation / std::max(step.cwiseAbs().maxCoeff(), 1e-300));
  for (int i = 0; i < step.size(); ++i) {
    if (step[i] < 0.0) part = std::min(part, box.lower[i] / step[i]);
    if (step[i] > 0.0) part = std::min(part, box.upper[i] / step[i]);
  }
  return part;
}

// Halves the step until E falls (Armijo); the slack is E's rounding error, below which a fall cannot be seen.
bool descend(const Problem& problem, Configuration& q, const Eigen::VectorXd& slope, const Eigen::VectorXd& step,
             double part) {
  const double before = energy(problem, q);
  const double rounding = 1e-14 * std::max(1.0, std::abs(before));
  for (int halving = 0; halving < 40; ++halving, part *= 0.5) {
    const Configuration next = moved(problem.arm, q, part * step);
    if (energy(problem, next) > before + 1e-4 * part * slope.dot(step) + rounding) continue;
    q = next;
    return true;
  }
  return false;
}

double freeNorm(const std::vector<int>& free, const Eigen::VectorXd& slope) {
  return free.empty() ? 0.0 : slope(free).cwiseAbs().maxCoeff();
}

// Newton steps from q, in place; returns how many.
int newton(const Problem& problem, Configuration& q, double tolerance) {
  for (int iteration = 0;; ++iteration) {
    const Eigen::VectorXd slope = gradient(problem, q);
    const Box box(problem.arm, q);
    const std::vector<int> free = freeCoordinates(box, slope);
    if (freeNorm(free, slope) <= tolerance || iteration == 500) return iteration;
    const Eigen::VectorXd step = newtonStep(box, free, slope, hessian(problem, q));
    if (!descend(problem, q, slope, step, longestPart(box, step))) return iteration;
  }
}

JointTorques perJoint(const Arm& arm, const Eigen::VectorXd& values) {
  JointTorques result;
  int first = 0;
  for (const Link& link : arm.links) {
    result.emplace_back(values.segment(first, freedoms(link)));
    first += freedoms(link);
  }
  return result;
}

Equilibrium assess(const Problem& problem, const Configuration& q, int iterations) {
  const Eigen::VectorXd slope = gradient(problem, q);
  const std::vector<int> free = freeCoordinates(Box(problem.arm, q), slope);
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(slope.size());
  residual(free) = -slope(free);
  Equilibrium result;
  result.configuration = q;
  result.residual = perJoint(problem.arm, residual);
  result.gradient_norm = freeNorm(free, slope);
  result.converged = result.gradient_norm <= kTolerance;
  result.stiffness = std::numeric_limits<double>::infinity();
  if (!free.empty()) {
    const Eigen::MatrixXd reduced = hessian(problem, q)(free, free);
    result.stiffness = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(reduced).eigenvalues().minCoeff();
  }
  int first = 0;
  for (const Link& link : problem.arm.links) {
    result.at_stop.push_back(std::find(free.begin(), free.end(), first) == free.end());
    first += freedoms(link);
  }
  result.iterations = iterations;
  return result;
}

}  // namespace

double largestRotation(const Arm& arm, const Configuration& a, const Configuration& b) {
  double result = 0.0;
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const double turned = arm.links[i].joint == Joint::kRevolute
                              ? std::abs(a[i].angle - b[i].angle)
                              : Eigen::AngleAxisd(a[i].rotation.transpose() * b[i].rotation).angle();
    result = std::max(result, turned);
  }
  return result;
}

Configuration restPose(const Arm& arm) {
  Configuration result(arm.links.size());
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    if (arm.links[i].joint == Joint::kRevolute)
      result[i].angle = std::clamp(0.3, arm.links[i].lower, arm.links[i].upper);
  }
  return result;
}

double totalEnergy(const Arm& arm, std::span<const double> shafts, const Configuration& configuration) {
  assert(shafts.size() == arm.muscles.size() && configuration.size() == arm.links.size());
  return energy({arm, shafts}, configuration);
}

JointTorques jointTorque(const Arm& arm, std::span<const double> shafts, const Configuration& configuration) {
  assert(shafts.size() == arm.muscles.size() && configuration.size() == arm.links.size());
  return perJoint(arm, -gradient({arm, shafts}, configuration));
}

Equilibrium minimise(const Arm& arm, std::span<const double> shafts, const Configuration& start) {
  assert(shafts.size() == arm.muscles.size() && start.size() == arm.links.size());
  Configuration q = moved(arm, start, Eigen::VectorXd::Zero(freedoms(arm)));
  const int iterations = newton({arm, shafts}, q, kTolerance);
  return assess({arm, shafts}, q, iterations);
}

Equilibrium followFromRest(const Arm& arm, std::span<const double> shafts, int steps) {
  assert(shafts.size() == arm.muscles.size() && steps >= 1);
  Configuration q = restPose(arm);
  std::vector<double> now(shafts.size());
  double largest_jump = 0.0;
  int iterations = 0;
  for (int step = 0; step <= steps; ++step) {
    for (std::size_t i = 0; i < now.size(); ++i) now[i] = shafts[i] * step / steps;
    const Configuration before = q;
    // On the way 1e-5 N m is near enough to stay on the branch.
    iterations += newton({arm, now}, q, step < steps ? 1e-5 : kTolerance);
    if (step > 0) largest_jump = std::max(largest_jump, largestRotation(arm, before, q));
  }
  Equilibrium result = assess({arm, shafts}, q, iterations);
  result.largest_jump = largest_jump;
  return result;
}

double largestStrain(const Arm& arm, std::span<const double> shafts, const Configuration& configuration) {
  const Placement<double> placement(arm, configuration, Eigen::VectorXd::Zero(freedoms(arm)));
  double result = 0.0;
  for (std::size_t i = 0; i < arm.muscles.size(); ++i) {
    result = std::max(result, cordExpansion(arm.muscles[i], arm, shafts[i], placement) / arm.muscles[i].cord_rest);
  }
  return result;
}

}  // namespace simgap::reality
