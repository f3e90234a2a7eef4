#include "simgap/simulate/equilibrium_arm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/random.h"
#include "simgap/core/rotation.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap {
namespace {

constexpr double kLongestStep = 0.8;     // [rad] of a degree of freedom: beyond, the quadratic says nothing
constexpr double kLastStep = 1e-6;       // [rad]: the error behind such a Newton step is of the order of its square
constexpr double kArmijo = 1e-4;         // share of the predicted decrease that a step has to reach
constexpr double kRounding = 1e-13;      // of the energy: smaller increases are not real
constexpr double kStopTolerance = 1e-9;  // [rad], a joint this near its stop may be held by it
// On the sample arm with its parameters drawn anew 60 times, 7 of 4800 direct ways from rest ended on another branch
// than follow() does; all but one of them had two doubts, as had 2 % of the others.
constexpr int kDoubtsAllowed = 1;
constexpr double kFarFromRest = 1.5;  // [rad]
// follow(): steps of the shafts, as shares of their way
constexpr double kFirstStep = 0.25;
constexpr double kShortestStep = 1.0 / 128.0;
constexpr double kLongestMove = 0.5;    // [rad] of a joint in one step
constexpr int kMostEvaluations = 4000;  // some 100 times what a pose of an arm takes

void clamp(const ArmModel& model, std::vector<JointPosition>& joints) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    joints[j].angle = std::clamp(joints[j].angle, model.joints[j].lower_limit, model.joints[j].upper_limit);
  }
  coupleJoints(model, joints);
}

}  // namespace

const ArmModel& withoutRopes(const ArmModel& model) {
  for (const Muscle& muscle : model.muscles) {
    if (!muscle.rope) continue;
    throw ConfigError(
        fmt::format("{}: muscle '{}' is a rope (line: rope), which equilibria do not know, expected "
                    "evaluator bullet (of calibrate with optimizer es or cma-es)",
                    model.name, muscle.name));
  }
  return model;
}

EquilibriumArm::EquilibriumArm(const ArmModel& model)
    : energy_(model),
      observation_(model),
      shafts_(model.commands()),
      // Computed, not only sized: what is copied before it is used is initialised.
      factor_(Eigen::MatrixXd::Identity(energy_.degreesOfFreedom(), energy_.degreesOfFreedom())) {
  const int n = energy_.degreesOfFreedom();
  joints_ = before_ = reached_ = rest_ = start_ = startPosition(model);
  held_.assign(static_cast<std::size_t>(n), 0);
  bound_ = held_;
  given_.resize(n);
  torque_.setZero(n);
  reduced_.resize(n, n);
  inverse_.resize(n, n);
  step_.resize(n);
  push_.resize(n);
  findCouplings();
}

void EquilibriumArm::findCouplings() {
  couplings_.clear();
  const ArmModel& model = energy_.model();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (!joint.follows()) continue;
    couplings_.push_back({energy_.firstDof(static_cast<int>(j)), energy_.firstDof(joint.leader), joint.coupling_ratio});
  }
}

void EquilibriumArm::setModel(const ArmModel& model) {
  energy_.setModel(model);
  observation_.setModel(model);
  findCouplings();
  rest_known_ = false;
}

void EquilibriumArm::setHistory(double time, std::span<const double> shafts_before) {
  energy_.setHistory(time, shafts_before);
  if (energy_.needsHistory()) rest_known_ = false;
}

EquilibriumSolution EquilibriumArm::solveFrom(std::span<const JointPosition> from, std::span<const double> shafts,
                                              int max_iterations) {
  std::copy(from.begin(), from.end(), joints_.begin());
  clamp(energy_.model(), joints_);
  energy_.setShafts(shafts);
  torque_.setZero();
  return descend(max_iterations);
}

EquilibriumSolution EquilibriumArm::descend(int max_iterations) {
  EquilibriumSolution solution;
  evaluate();
  for (solution.iterations = 1; solution.iterations < max_iterations;) {
    solution.torque = findHeld();
    const bool convex = newtonStep();
    const double longest = step_.lpNorm<Eigen::Infinity>();
    solution.doubts += !convex;
    if (convex && longest < kLastStep) {
      applyStep(1.0);
      solution.stable = true;
      return solution;
    }
    double scale = std::min(1.0, kLongestStep / longest);
    std::copy(joints_.begin(), joints_.end(), before_.begin());
    const double energy = energy_.energy();
    const double slope = energy_.gradient().dot(step_);
    for (;;) {
      applyStep(scale);
      evaluate();
      ++solution.iterations;
      if (energy_.energy() <= energy + kArmijo * scale * slope + kRounding * std::abs(energy)) break;
      ++solution.doubts;
      std::copy(before_.begin(), before_.end(), joints_.begin());
      scale *= 0.5;
      if (solution.iterations >= max_iterations) {
        evaluate();
        break;
      }
    }
  }
  return solution;
}

double EquilibriumArm::findHeld() {
  const ArmModel& model = energy_.model();
  if (!couplings_.empty()) push_ = energy_.gradient() - torque_;
  for (const Coupling& c : couplings_) {
    push_[c.leader] += c.ratio * push_[c.follower];
    push_[c.follower] = 0.0;
  }
  const bool coupled = !couplings_.empty();
  const auto push = [&](int d) { return coupled ? push_[d] : energy_.gradient()[d] - torque_[d]; };
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (!joint.hasAxis() || joint.follows()) continue;
    const int d = energy_.firstDof(static_cast<int>(j));
    held_[d] = (joints_[j].angle <= joint.lower_limit + kStopTolerance && push(d) > 0.0) ||
               (joints_[j].angle >= joint.upper_limit - kStopTolerance && push(d) < 0.0);
  }
  for (const Coupling& c : couplings_) held_[c.follower] = held_[c.leader];
  double torque = 0.0;
  for (int d = 0; d < energy_.degreesOfFreedom(); ++d) torque = std::max(torque, held_[d] ? 0.0 : std::abs(push(d)));
  return torque;
}

/// The Newton step within the joint limits. \returns whether the energy is convex here; where it is not, the step goes
/// down all the same.
bool EquilibriumArm::newtonStep() {
  std::copy(held_.begin(), held_.end(), bound_.begin());
  given_.setZero();
  bool convex = solveReduced();
  while (stopAtLimit()) convex &= solveReduced();
  return convex;
}

/// Minimises the quadratic model with the bound degrees of freedom moved as given.
bool EquilibriumArm::solveReduced() {
  const int n = energy_.degreesOfFreedom();
  reduced_ = energy_.hessian();
  step_ = torque_ - energy_.gradient();
  foldCouplings();
  for (int d = 0; d < n; ++d) {
    if (!bound_[d]) continue;
    if (given_[d] != 0.0) step_ -= given_[d] * reduced_.col(d);
    reduced_.row(d).setZero();
    reduced_.col(d).setZero();
    reduced_(d, d) = 1.0;
  }
  for (int d = 0; d < n; ++d) {
    if (bound_[d]) step_[d] = given_[d];
  }
  factor_.compute(reduced_);
  if (factor_.info() == Eigen::Success) {
    factor_.solveInPlace(step_);
    for (const Coupling& c : couplings_) step_[c.follower] = c.ratio * step_[c.leader];
    return true;
  }
  // Down all the same: Cholesky with an added multiple of the identity (Nocedal & Wright 2006, algorithm 3.3).
  constexpr int kMostShifts = 30;
  double shift = 0.0;
  for (int k = 0; k < kMostShifts && factor_.info() != Eigen::Success; ++k) {
    const double next = std::max(4.0 * shift, 1e-3 * reduced_.norm());
    for (int d = 0; d < n; ++d) {
      if (!bound_[d]) reduced_(d, d) += next - shift;
    }
    shift = next;
    factor_.compute(reduced_);
  }
  factor_.solveInPlace(step_);
  for (const Coupling& c : couplings_) step_[c.follower] = c.ratio * step_[c.leader];
  return false;
}

/// Followers go with their leaders, q = offset + ratio q_leader: T^T H T and T^T g with the followers' rows left empty.
void EquilibriumArm::foldCouplings() {
  for (const Coupling& c : couplings_) {
    reduced_.row(c.leader) += c.ratio * reduced_.row(c.follower);
    reduced_.col(c.leader) += c.ratio * reduced_.col(c.follower);
    step_[c.leader] += c.ratio * step_[c.follower];
    reduced_.row(c.follower).setZero();
    reduced_.col(c.follower).setZero();
    reduced_(c.follower, c.follower) = 1.0;
    step_[c.follower] = 0.0;
  }
}

/// Lets the joint that the step carries farthest beyond its limit go just there. The face of the box that it reaches
/// holds a point of the way to the unlimited minimum, so the model still decreases.
bool EquilibriumArm::stopAtLimit() {
  const ArmModel& model = energy_.model();
  int worst = -1;
  double farthest = 0.0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = model.joints[j];
    const int d = energy_.firstDof(static_cast<int>(j));
    if (!joint.hasAxis() || joint.follows() || bound_[d]) continue;
    const double to_lower = joint.lower_limit - joints_[j].angle;
    const double to_upper = joint.upper_limit - joints_[j].angle;
    const double beyond = std::max(to_lower - step_[d], step_[d] - to_upper);
    if (beyond <= farthest) continue;
    farthest = beyond;
    worst = d;
    given_[d] = step_[d] < to_lower ? to_lower : to_upper;
  }
  if (worst < 0) return false;
  bound_[worst] = 1;
  return true;
}

void EquilibriumArm::applyStep(double scale) {
  const ArmModel& model = energy_.model();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const int d = energy_.firstDof(static_cast<int>(j));
    if (!model.joints[j].hasAxis()) {
      joints_[j].rotation = (joints_[j].rotation * quaternionExpSo3(scale * step_.segment<3>(d))).normalized();
    } else {
      joints_[j].angle =
          std::clamp(joints_[j].angle + scale * step_[d], model.joints[j].lower_limit, model.joints[j].upper_limit);
    }
  }
  if (!couplings_.empty()) coupleJoints(model, joints_);
}

EquilibriumSolution EquilibriumArm::solve(std::span<const double> shafts) {
  if (!rest_known_) {
    std::fill(shafts_.begin(), shafts_.end(), 0.0);
    solveFrom(start_, shafts_);
    std::copy(joints_.begin(), joints_.end(), rest_.begin());
    rest_known_ = true;
  }
  EquilibriumSolution direct = solveFrom(rest_, shafts);
  if (direct.stable && direct.doubts <= kDoubtsAllowed && wayFrom(rest_) < kFarFromRest) return direct;
  EquilibriumSolution followed = follow(shafts);
  followed.iterations += direct.iterations;
  return followed;
}

double EquilibriumArm::wayFrom(const std::vector<JointPosition>& position) const {
  double way = 0.0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    way = std::max(way, jointError(energy_.model().joints[j].type, position[j], joints_[j]));
  }
  return way;
}

EquilibriumSolution EquilibriumArm::follow(std::span<const double> shafts) {
  std::copy(rest_.begin(), rest_.end(), reached_.begin());
  EquilibriumSolution solution;
  int iterations = 0;
  double way = 0.0;  // of the shafts, 1 at their end
  double step = kFirstStep;
  while (way < 1.0) {
    if (iterations > kMostEvaluations || interruptRequested()) {
      solution.stable = false;
      break;
    }
    const double next = std::min(1.0, way + step);
    for (std::size_t m = 0; m < shafts_.size(); ++m) shafts_[m] = next * shafts[m];
    solution = solveFrom(reached_, shafts_);
    iterations += solution.iterations;
    const bool branch_kept = solution.stable && solution.doubts == 0 && wayFrom(reached_) < kLongestMove;
    if (!branch_kept && step > kShortestStep) {
      step *= 0.5;
      continue;
    }
    // Where even the shortest step jumps, the branch has ended, and downhill is as good a guess as any.
    std::copy(joints_.begin(), joints_.end(), reached_.begin());
    way = next;
    step = std::min(kFirstStep, 2.0 * step);
  }
  solution.iterations = iterations;
  return solution;
}

std::vector<std::vector<JointPosition>> distinctEquilibria(EquilibriumArm& arm, std::span<const double> shafts,
                                                           std::span<const JointPosition> known) {
  constexpr int kStarts = 64;
  constexpr double kSame = 1e-4;   // [rad]
  constexpr double kSpread = 2.0;  // [rad] about the known equilibrium
  const ArmModel& model = arm.energy().model();
  std::vector<std::vector<JointPosition>> found{{known.begin(), known.end()}};
  const CounterRandom random(0);
  for (std::uint32_t start = 0; start < kStarts; ++start) {
    std::vector<JointPosition> from = found.front();
    for (std::uint32_t j = 0; j < from.size(); ++j) {
      const auto [x, y] = random.normalPair({start, j, 0});
      const auto [z, angle] = random.normalPair({start, j, 1});
      from[j].rotation = from[j].rotation * quaternionExpSo3(0.5 * kSpread * Eigen::Vector3d(x, y, z));
      from[j].angle += kSpread * angle;
    }
    if (!arm.solveFrom(from, shafts).stable) continue;
    const auto same = [&](const std::vector<JointPosition>& other) {
      for (std::size_t j = 0; j < other.size(); ++j) {
        if (jointError(model.joints[j].type, other[j], arm.joints()[j]) > kSame) return false;
      }
      return true;
    };
    if (std::none_of(found.begin(), found.end(), same)) found.push_back(arm.joints());
  }
  return found;
}

void EquilibriumArm::linearise() {
  evaluate();
  findHeld();
  std::copy(held_.begin(), held_.end(), bound_.begin());
  given_.setZero();
  solveReduced();
  inverse_.setIdentity();
  factor_.solveInPlace(inverse_);
  for (const Coupling& c : couplings_) {  // T (T^T H T)^-1 T^T
    inverse_.row(c.follower) = c.ratio * inverse_.row(c.leader);
    inverse_.col(c.follower) = c.ratio * inverse_.col(c.leader);
  }
}

void EquilibriumArm::applyInverseHessian(Eigen::Ref<Eigen::MatrixXd> columns) {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    for (Eigen::Index d = 0; d < columns.rows(); ++d) step_[d] = held_[d] ? 0.0 : columns(d, c);
    columns.col(c).noalias() = inverse_.lazyProduct(step_);
  }
}

void EquilibriumArm::sensitivities(std::span<const StaticParameter> parameters, Eigen::Ref<Eigen::MatrixXd> columns) {
  energy_.differentiate(parameters, columns);
  applyInverseHessian(columns);
  columns = -columns;
}

bool EquilibriumArm::hold(const Eigen::VectorXd& torque) {
  constexpr int kIterations = 12;
  constexpr double kFarthest = 0.6;  // [rad] of a joint: farther, friction says little of where an arm is
  std::copy(joints_.begin(), joints_.end(), reached_.begin());
  torque_ = torque;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    evaluate();
    findHeld();
    if (!newtonStep()) break;
    const double longest = step_.lpNorm<Eigen::Infinity>();
    applyStep(std::min(1.0, kLongestStep / longest));
    if (wayFrom(reached_) > kFarthest) break;
    if (longest < kLastStep) return true;
  }
  std::copy(reached_.begin(), reached_.end(), joints_.begin());
  torque_.setZero();
  evaluate();
  return false;
}

const std::vector<JointPosition>& EquilibriumArm::observe(std::span<const double> shafts,
                                                          std::span<const double> shafts_before) {
  if (observation_.plain()) return joints_;
  observation_.observe(*this, shafts, shafts_before, observed_);
  return observed_;
}

void EquilibriumArm::observedSensitivities(std::span<const StaticParameter> parameters,
                                           Eigen::Ref<Eigen::MatrixXd> columns) {
  sensitivities(parameters, columns);
  if (!observation_.plain()) observation_.chain(*this, parameters, columns);
}

}  // namespace simgap
