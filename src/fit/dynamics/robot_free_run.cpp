#include "simgap/fit/dynamics/robot_free_run.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "simgap/core/blocks.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/measure/logs/motion.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLongestStep = 1e-3;  // [s]
constexpr double kNear = 0.1;          // of a motion's range: a robot that is still near it

/// What a robot does between two rows of its log, which are a straight line.
struct Course {
  VectorXd effort, position, velocity;  ///< [N m], shape (N) each
};

Course courseAt(const RobotLog& log, std::size_t row, const std::vector<double>& constants) {
  const Index n = std::ssize(log.joints);
  Course course{VectorXd(n), VectorXd(n), VectorXd(n)};
  for (Index c = 0; c < n; ++c) {
    const RobotJointLog& joint = log.joints[c];
    course.effort[c] = joint.effort[row] * (constants.empty() ? 1.0 : constants[c]);
    course.position[c] = joint.position[row];
    course.velocity[c] = joint.velocity[row];
  }
  return course;
}

/// A robot between two rows of its log.
class FreeRobot {
 public:
  FreeRobot(const RobotModel& model, std::span<const JointGains> gains)
      : model_(model),
        regressor_(model.arm, friction::find(model.law)),
        work_(regressor_.workspace()),
        y_(regressor_.coordinates(), regressor_.columns()),
        n_(static_cast<Index>(regressor_.coordinates())),
        mass_(n_, n_),
        proportional_(VectorXd::Zero(n_)),
        derivative_(VectorXd::Zero(n_)),
        integral_(VectorXd::Zero(n_)) {
    const std::vector<double> none(regressor_.coordinates());
    moment_ = {none, none, none, none};
    for (std::size_t c = 0; c < gains.size(); ++c) {
      const double unit = model.currents ? model.torque_constants[c] : 1.0;
      proportional_[c] = unit * gains[c].proportional;
      derivative_[c] = unit * gains[c].derivative;
      integral_[c] = unit * gains[c].integral;
    }
  }

  void start(const Course& at) {
    q_ = at.position;
    v_ = at.velocity;
    error_sum_ = acceleration_ = viscous_ = dry_ = VectorXd::Zero(n_);
  }

  /// \param held  effort of the step; position and velocity are those of its end
  void step(const Course& held, double h) {
    terms();
    const VectorXd damping = derivative_ + viscous_;
    MatrixXd a = mass_;
    a.diagonal() += h * damping + h * h * proportional_;
    const VectorXd pushed = held.effort - rest_ + proportional_.cwiseProduct(held.position - q_) +
                            derivative_.cwiseProduct(held.velocity) + integral_.cwiseProduct(error_sum_);
    const Eigen::LLT<MatrixXd> llt(a);
    if (llt.info() != Eigen::Success) {
      throw NumericsError("found an inertia of the robot that is not positive, expected one that can move");
    }
    const MatrixXd mobility = llt.solve(MatrixXd::Identity(n_, n_));
    const VectorXd before = v_;
    v_ = mobility * (mass_ * v_ + h * pushed);
    stopByFriction(mobility, h * dry_);
    if (regressor_.law().needsLoad()) acceleration_ = (v_ - before) / h;
    q_ += h * v_;
    error_sum_ += h * (held.position - q_);
    if (!q_.allFinite()) throw NumericsError("the free motion grows without bound: check the gains and the robot");
  }

  const VectorXd& position() const { return q_; }

 private:
  /// What bodies, rotors and offsets ask for at an acceleration, at the present position and velocity.
  VectorXd rigidEffort(const VectorXd& acceleration) {
    VectorXd::Map(moment_.acceleration.data(), n_) = acceleration;
    regressor_.rows(moment_, model_.curves, work_, y_);
    const Index first = regressor_.bodyColumn(0), count = regressor_.columns() - first;
    VectorXd effort = y_.rightCols(count) * model_.parameters.tail(count);
    for (Index c = 0; c < n_; ++c) effort[c] += model_.parameters[regressor_.offsetColumn(c)];
    return effort;
  }

  /// M, h_0 without dry and viscous friction, and what these two are at this velocity; the load of friction is that of
  /// the last step's acceleration.
  void terms() {
    VectorXd::Map(moment_.position.data(), n_) = q_;
    VectorXd::Map(moment_.velocity.data(), n_) = v_;
    std::ranges::fill(moment_.direction, 1.0);
    rest_ = rigidEffort(acceleration_);
    for (Index c = 0; c < n_; ++c) {
      Index at = regressor_.frictionColumn(c);
      double dry = 0.0, viscous = 0.0;
      for (const FrictionTerm& term : regressor_.law().terms) {
        (term.basis == FrictionBasis::kVelocity ? viscous : dry) += y_(c, at) * model_.parameters[at];
        ++at;
      }
      viscous_[c] = v_[c] != 0.0 ? std::max(viscous / v_[c], 0.0) : 0.0;
      dry_[c] = std::max(dry, 0.0);
    }
    if (regressor_.law().needsLoad()) rest_ = rigidEffort(VectorXd::Zero(n_));
    for (Index k = 0; k < n_; ++k) mass_.col(k) = rigidEffort(VectorXd::Unit(n_, k)) - rest_;
    mass_ = 0.5 * (mass_ + mass_.transpose()).eval();  // rounding
    for (Index c = 0; c < n_; ++c) rest_[c] += regressor_.dynamics().springTorque(c, q_[c]);
  }

  /// Impulses of dry friction lead every velocity to 0, as far as they reach.
  void stopByFriction(const MatrixXd& mobility, const VectorXd& most) {
    constexpr int kSweeps = 100;
    constexpr double kClose = 1e-12;
    VectorXd impulse = VectorXd::Zero(n_);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      double changed = 0.0;
      for (Index c = 0; c < n_; ++c) {
        const double wanted = std::clamp(impulse[c] + v_[c] / mobility(c, c), -most[c], most[c]);
        v_ -= mobility.col(c) * (wanted - impulse[c]);
        changed = std::max(changed, std::abs(wanted - impulse[c]));
        impulse[c] = wanted;
      }
      if (changed <= kClose * most.maxCoeff()) return;
    }
  }

  const RobotModel& model_;
  RobotRegressor regressor_;
  RobotRegressor::Workspace work_;
  RegressorMatrix y_;
  Index n_;
  RobotMotion moment_;
  MatrixXd mass_;
  VectorXd proportional_, derivative_, integral_;  ///< of the controller [N m]
  VectorXd q_, v_, error_sum_;
  VectorXd acceleration_;          ///< of the last step where friction knows a load, else 0
  VectorXd rest_, viscous_, dry_;  ///< [N m], [N m s/rad], [N m]
};

void runSession(const RobotModel& model, const RobotLog& log, std::span<const JointGains> gains, const Block& session,
                double longest_step, MatrixXd& position) {
  FreeRobot robot(model, gains);
  Course from = courseAt(log, session.begin, model.torque_constants);
  robot.start(from);
  position.row(session.begin) = robot.position();
  for (std::size_t row = session.begin + 1; row < session.end; ++row) {
    if (interruptRequested()) return;
    const Course to = courseAt(log, row, model.torque_constants);
    const double dt = log.time[row] - log.time[row - 1];
    const int steps = std::max(1, static_cast<int>(std::ceil(dt / longest_step - 1e-9)));
    const auto between = [&](VectorXd Course::*of, double share) -> VectorXd {
      return (1.0 - share) * (from.*of) + share * (to.*of);
    };
    for (int k = 0; k < steps; ++k) {
      const double middle = (k + 0.5) / steps, end = (k + 1.0) / steps;
      robot.step({between(&Course::effort, middle), between(&Course::position, end), between(&Course::velocity, end)},
                 dt / steps);
    }
    position.row(row) = robot.position();
    from = to;
  }
}

double rms(const VectorXd& error) { return std::sqrt(error.squaredNorm() / static_cast<double>(error.size())); }

/// How long no session has gone further than `tolerance` from its log [s].
double nearFor(const RobotLog& log, const std::vector<Block>& sessions, const VectorXd& error, double tolerance) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Block& session : sessions) {
    std::size_t i = session.begin;
    while (i + 1 < session.end && std::abs(error[i]) <= tolerance) ++i;
    shortest = std::min(shortest, log.time[i] - log.time[session.begin]);
  }
  return shortest;
}

}  // namespace

std::vector<JointGains> readJointGains(const YamlNode& root, const RobotModel& model) {
  root.at("format").oneOf({"simgap/joint-gains/1"});
  const YamlNode joints = root.at("joints");
  std::vector<JointGains> gains;
  for (const LoggedJoint& joint : loggedJoints(model.arm)) {
    const YamlNode node = joints.at(joint.name);
    const std::string angle = joint.slides ? "m" : "rad";
    const std::string effort = model.currents ? "A" : joint.slides ? "N" : "Nm";
    const auto gain = [&](const std::string& key) {
      const auto found = node.find(key);
      return found ? found->number(kNonNegative) : 0.0;
    };
    gains.push_back({node.at(fmt::format("proportional_{}_{}", effort, angle)).number(kNonNegative),
                     gain(fmt::format("derivative_{}s_{}", effort, angle)),
                     gain(fmt::format("integral_{}_{}_s", effort, angle))});
  }
  root.expectAllRead();
  return gains;
}

RobotFreeRun runFreely(const RobotModel& model, const RobotLog& log, std::span<const JointGains> gains) {
  const std::vector<Block> sessions = splitRuns(log.time, log.session);  // a gap begins anew
  const Index rows = log.rows(), n = std::ssize(log.joints);
  MatrixXd whole(rows, n), half(rows, n);
  tbb::parallel_for(std::size_t{0}, 2 * sessions.size(), [&](std::size_t k) {
    const bool halved = k % 2 == 1;
    runSession(model, log, gains, sessions[k / 2], halved ? 0.5 * kLongestStep : kLongestStep, halved ? half : whole);
  });
  stopIfInterrupted();
  RobotFreeRun run{std::move(half), {}, {}, {}, {}, {}};
  const std::vector<LoggedJoint> joints = loggedJoints(model.arm);
  for (Index c = 0; c < n; ++c) {
    const VectorXd measured = VectorXd::Map(log.joints[c].position.data(), rows);
    const VectorXd error = run.position.col(c) - measured;
    run.rms.push_back(rms(error));
    run.range.push_back(measured.maxCoeff() - measured.minCoeff());
    run.half_step.push_back(rms(whole.col(c) - run.position.col(c)));
    run.near_s.push_back(nearFor(log, sessions, error, kNear * run.range.back()));
    run.beyond_limit.push_back(std::max(
        {0.0, run.position.col(c).maxCoeff() - joints[c].upper, joints[c].lower - run.position.col(c).minCoeff()}));
  }
  return run;
}

}  // namespace simgap
