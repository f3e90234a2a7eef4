#include "simgap/fit/dynamics/excitation.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"
#include "simgap/optimize/cma_es.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kChunks = 8;   // of a motion's moments, in parallel; their sums are added in this order
constexpr int kMomentsPerWave = 40;  // of the fastest harmonic
constexpr double kWithin = 0.99;     // of the limits: between two moments a joint may go a little further
constexpr int kSeriesKept = 100, kSeriesDrawn = 3000;  // at random: what the search begins with, and is compared with
constexpr int kGenerations = 400;
constexpr double kBroken = 10.0, kPerShare = 100.0;  // cost of a limit that is broken, beyond any information
constexpr double kNothing = 1e-12;                   // of a column's information: what no motion tells
constexpr std::uint32_t kDrawPurpose = 31;

/// How far a motion breaks limits of effort and distance, as shares of them.
double broken(double value, double limit) { return std::max(0.0, value / limit - 1.0); }

class Search {
 public:
  Search(const ArmModel& arm, const FrictionLaw& law, const ExcitationLimits& limits)
      : arm_(arm), limits_(limits), regressor_(arm, law), curves_(regressor_.coordinates()), given_(given()) {
    const BaseParameters base = baseParameters(regressor_, arm);
    if (limits.payload.empty()) {
      columns_ = base.columns;
      names_ = base.names;
    } else {
      const Index first = regressor_.bodyColumn(payloadBody());
      for (Index k = 0; k < 4; ++k) columns_.push_back(first + k);
      for (const char* of : {"m", "mc_x", "mc_y", "mc_z"}) names_.push_back("payload." + std::string(of));
    }
    for (std::size_t k = 0; k < kChunks; ++k) chunks_.push_back(Chunk{regressor_.workspace(), {}, {}, {}, 0.0});
  }

  const std::vector<std::string>& names() const { return names_; }
  std::vector<std::string> units() const {
    std::vector<std::string> units;
    for (const Index column : columns_) units.push_back(regressor_.units()[column]);
    return units;
  }
  std::size_t unknowns() const { return regressor_.coordinates() * ownUnknowns(); }

  /// A series within the joints' limits of position, velocity and acceleration, whatever the numbers are.
  FourierMotion motionOf(const std::vector<double>& x) const {
    const Index n = std::ssize(limits_.joints), harmonics = limits_.harmonics;
    MatrixXd a = MatrixXd::Zero(n, harmonics), b = a;
    VectorXd start = VectorXd::Zero(n);
    for (Index j = 0; j < n; ++j) {
      const JointExcitationLimits& limit = limits_.joints[j];
      const double* own = x.data() + j * static_cast<Index>(ownUnknowns());
      const double size = limit.velocity / std::sqrt(static_cast<double>(harmonics));
      for (Index k = 1; k < harmonics; ++k) {
        a(j, k) = size * own[k - 1];
        b(j, k) = size * own[harmonics - 1 + k - 1];
        // At rest in the beginning: sum_k a_k = 0 and sum_k k b_k = 0.
        a(j, 0) -= a(j, k);
        b(j, 0) -= static_cast<double>(k + 1) * b(j, k);
      }
      const JointExcursion raw = excursionOf({limits_.duration, a.row(j), b.row(j), VectorXd::Zero(1)});
      const double range = raw.upper - raw.lower;
      const double scale = std::min({1.0, kWithin * limit.velocity / std::max(raw.velocity, 1e-12),
                                     kWithin * limit.acceleration / std::max(raw.acceleration, 1e-12),
                                     kWithin * (limit.upper - limit.lower) / std::max(range, 1e-12)});
      a.row(j) *= scale;
      b.row(j) *= scale;
      const double between = kWithin * (limit.upper - limit.lower), inset = 0.5 * (1.0 / kWithin - 1.0) * between;
      const double where = 1.0 / (1.0 + std::exp(-2.0 * own[2 * harmonics - 2]));
      start[j] = limit.lower + inset + where * (between - scale * range) - scale * raw.lower;
    }
    return {limits_.duration, std::move(a), std::move(b), std::move(start)};
  }

  /// Finite everywhere; at least kBroken where a limit is broken.
  double cost(const FourierMotion& motion) {
    const double worst = sum(motion);
    if (worst > 0.0) return kBroken + kPerShare * worst;
    return std::min(precision().log_sd, kBroken);
  }

  /// Of the motion that was summed last.
  ExcitationPrecision precision() const {
    const Index k = information_.rows();
    const VectorXd scale = information_.diagonal().cwiseMax(kNothing).cwiseSqrt().cwiseInverse();
    MatrixXd scaled = scale.asDiagonal() * information_ * scale.asDiagonal();
    scaled.diagonal().array() += kNothing;
    const SymmetricEigen eigen = symmetricEigen(scaled);
    const VectorXd values = eigen.values.cwiseMax(kNothing);
    ExcitationPrecision precision;
    const MatrixXd inverse = eigen.vectors * values.cwiseInverse().asDiagonal() * eigen.vectors.transpose();
    precision.sd = scale.cwiseProduct(inverse.diagonal().cwiseSqrt());
    precision.log_sd = (scale.array().log().sum() - 0.5 * values.array().log().sum()) / static_cast<double>(k);
    precision.condition = std::sqrt(values[k - 1] / values[0]);
    return precision;
  }

  /// Over the rows of the trajectory; and the least of each distance.
  std::pair<std::vector<JointExcursion>, std::vector<double>> reached(const FourierMotion& motion) const {
    std::vector<JointExcursion> joints(regressor_.coordinates(), {kInfinity, -kInfinity, 0.0, 0.0, 0.0});
    std::vector<double> nearest(limits_.distances.size(), kInfinity);
    RobotRegressor::Workspace work = regressor_.workspace();
    RegressorMatrix y(regressor_.coordinates(), regressor_.columns());
    RobotMotion now;
    const auto rows = static_cast<std::size_t>(std::ceil(limits_.rate * limits_.duration));
    for (std::size_t i = 0; i <= rows; ++i) {
      stopIfInterrupted();
      play(motion, static_cast<double>(i) / limits_.rate, now, work, y);
      for (std::size_t j = 0; j < joints.size(); ++j) {
        JointExcursion& joint = joints[j];
        joint.lower = std::min(joint.lower, now.position[j]);
        joint.upper = std::max(joint.upper, now.position[j]);
        joint.velocity = std::max(joint.velocity, std::abs(now.velocity[j]));
        joint.acceleration = std::max(joint.acceleration, std::abs(now.acceleration[j]));
        joint.effort = std::max(joint.effort, std::abs(effort(j, now, y)));
      }
      for (std::size_t d = 0; d < nearest.size(); ++d) {
        nearest[d] = std::min(nearest[d], distance(limits_.distances[d], work));
      }
    }
    return {joints, nearest};
  }

 private:
  struct Chunk {
    RobotRegressor::Workspace work;
    RobotMotion motion;
    RegressorMatrix rows;
    MatrixXd information;
    double worst = 0.0;
  };

  std::size_t ownUnknowns() const { return 2 * static_cast<std::size_t>(limits_.harmonics) - 1; }
  int moments() const { return kMomentsPerWave * limits_.harmonics; }

  std::size_t payloadBody() const {
    const std::vector<int>& bodies = regressor_.dynamics().bodies();
    const auto found = std::ranges::find_if(bodies, [&](int b) { return arm_.bodies[b].name == limits_.payload; });
    if (found == bodies.end()) {
      throw ConfigError(
          fmt::format("payload: {} does not move, expected a body that a joint carries", limits_.payload));
    }
    return static_cast<std::size_t>(found - bodies.begin());
  }

  /// The file's bodies and friction, as parameters of all columns.
  VectorXd given() const {
    VectorXd parameters = VectorXd::Zero(regressor_.columns());
    const InverseDynamics& dynamics = regressor_.dynamics();
    parameters.segment(regressor_.bodyColumn(0), dynamics.parameters()) = dynamics.parametersOf(arm_);
    for (std::size_t c = 0; c < regressor_.coordinates(); ++c) {
      const Joint& joint = arm_.joints[dynamics.joints()[c]];
      Index at = regressor_.frictionColumn(c);
      for (const FrictionTerm& term : regressor_.law().terms) {
        if (term.basis == FrictionBasis::kVelocity) parameters[at] = joint.viscous_friction;
        if (term.basis == FrictionBasis::kDirection && term.shape != FrictionShape::kStatic) {
          parameters[at] = joint.coulomb_friction;
        }
        ++at;
      }
    }
    return parameters;
  }

  JointExcursion excursionOf(const FourierMotion& one) const {
    JointExcursion most{kInfinity, -kInfinity, 0.0, 0.0, 0.0};
    RobotMotion now;
    for (int i = 0; i < moments(); ++i) {
      one.at(limits_.duration * i / moments(), now);
      most.lower = std::min(most.lower, now.position[0]);
      most.upper = std::max(most.upper, now.position[0]);
      most.velocity = std::max(most.velocity, std::abs(now.velocity[0]));
      most.acceleration = std::max(most.acceleration, std::abs(now.acceleration[0]));
    }
    return most;
  }

  void play(const FourierMotion& motion, double time, RobotMotion& now, RobotRegressor::Workspace& work,
            Eigen::Ref<RegressorMatrix> y) const {
    motion.at(time, now);
    regressor_.rows(now, curves_, work, y);
  }

  double effort(std::size_t j, const RobotMotion& now, const RegressorMatrix& y) const {
    return y.row(j).dot(given_) + regressor_.dynamics().springTorque(j, now.position[j]);
  }

  double distance(const DistanceLimit& limit, const RobotRegressor::Workspace& work) const {
    const auto placed = [&](int body, const Eigen::Vector3d& point) -> Eigen::Vector3d {
      const auto& frame = work.motion.bodies[body];
      return frame.origin + frame.rotation * point;
    };
    const Eigen::Vector3d point = placed(limit.body, limit.point);
    if (limit.other < 0) return limit.normal.dot(point) - limit.plane;
    return (point - placed(limit.other, limit.other_point)).norm();
  }

  /// What one chunk of the moments tells, and the worst share by which it breaks a limit.
  void sumChunk(const FourierMotion& motion, std::size_t index, const VectorXd& weights) {
    Chunk& chunk = chunks_[index];
    const Index n = std::ssize(limits_.joints), count = std::ssize(columns_);
    RegressorMatrix y(n, regressor_.columns());
    const int first = moments() * static_cast<int>(index) / static_cast<int>(kChunks);
    const int end = moments() * static_cast<int>(index + 1) / static_cast<int>(kChunks);
    chunk.rows.resize(n * (end - first), count);
    chunk.worst = 0.0;
    for (int i = first; i < end; ++i) {
      play(motion, limits_.duration * i / moments(), chunk.motion, chunk.work, y);
      chunk.rows.middleRows(n * (i - first), n) = weights.asDiagonal() * y(Eigen::all, columns_);
      for (std::size_t j = 0; j < limits_.joints.size(); ++j) {
        const double over = broken(std::abs(effort(j, chunk.motion, y)), kWithin * limits_.joints[j].effort);
        chunk.worst = std::max(chunk.worst, over);
      }
      for (const DistanceLimit& limit : limits_.distances) {
        chunk.worst =
            std::max(chunk.worst, (limit.least / kWithin - distance(limit, chunk.work)) / (limit.least + 0.1));
      }
    }
    chunk.information.setZero(count, count);
    chunk.information.selfadjointView<Eigen::Lower>().rankUpdate(chunk.rows.transpose());
  }

  /// \returns the worst share by which the motion breaks a limit
  double sum(const FourierMotion& motion) {
    const double rows = limits_.rate * limits_.duration * limits_.periods / moments();  // that a moment stands for
    VectorXd weights(std::ssize(limits_.joints));
    for (Index j = 0; j < weights.size(); ++j) weights[j] = std::sqrt(rows) / limits_.joints[j].noise;
    tbb::parallel_for(std::size_t{0}, kChunks, [&](std::size_t k) { sumChunk(motion, k, weights); });
    information_ = chunks_.front().information;
    double worst = chunks_.front().worst;
    for (std::size_t k = 1; k < kChunks; ++k) {
      information_ += chunks_[k].information;
      worst = std::max(worst, chunks_[k].worst);
    }
    information_.triangularView<Eigen::StrictlyUpper>() = information_.transpose();
    return worst;
  }

  const ArmModel& arm_;
  const ExcitationLimits& limits_;
  RobotRegressor regressor_;
  std::vector<StribeckCurve> curves_;
  VectorXd given_;
  std::vector<Index> columns_;
  std::vector<std::string> names_;
  std::vector<Chunk> chunks_;
  MatrixXd information_;
};

std::vector<double> drawn(const CounterRandom& random, std::size_t unknowns, std::uint32_t draw) {
  std::vector<double> x;
  for (std::uint32_t i = 0; i < unknowns; ++i) x.push_back(random.normalPair({draw, i, 0, kDrawPurpose})[0]);
  return x;
}

}  // namespace

FourierMotion::FourierMotion(double duration, MatrixXd a, MatrixXd b, VectorXd start)
    : duration_(duration), a_(std::move(a)), b_(std::move(b)), start_(std::move(start)) {}

void FourierMotion::at(double time, RobotMotion& motion) const {
  const std::size_t n = static_cast<std::size_t>(start_.size());
  motion.position.assign(start_.begin(), start_.end());
  motion.velocity.assign(n, 0.0);
  motion.acceleration.assign(n, 0.0);
  motion.direction.assign(n, 0.0);
  for (Index k = 0; k < a_.cols(); ++k) {
    const double w = 2.0 * std::numbers::pi * static_cast<double>(k + 1) / duration_;
    const double sine = std::sin(w * time), cosine = std::cos(w * time);
    for (std::size_t j = 0; j < n; ++j) {
      const double a = a_(static_cast<Index>(j), k), b = b_(static_cast<Index>(j), k);
      motion.position[j] += (a * sine + b * (1.0 - cosine)) / w;
      motion.velocity[j] += a * cosine + b * sine;
      motion.acceleration[j] += w * (b * cosine - a * sine);
    }
  }
  for (std::size_t j = 0; j < n; ++j) {
    motion.direction[j] = motion.velocity[j] > 0.0 ? 1.0 : motion.velocity[j] < 0.0 ? -1.0 : 0.0;
  }
}

namespace {

/// Series that were drawn, and the best of them.
struct DrawnSeries {
  std::vector<double> best;
  double lowest = kInfinity;  ///< its cost
  int draws = 0;
  std::vector<FourierMotion> kept;              ///< within the limits
  std::vector<ExcitationPrecision> precisions;  ///< of these
};

/// No motion is delivered: the best one breaks a limit, or leaves something open that is asked for.
[[noreturn]] void refuseSearch(const ExcitationLimits& limits, double lowest) {
  if (lowest > kBroken) {
    throw ConfigError(
        fmt::format("no motion of {:g} s was found within the limits of effort and distance, expected "
                    "wider ones, or a start that keeps them",
                    limits.duration));
  }
  if (limits.payload.empty()) {
    throw ConfigError(
        fmt::format("no motion of {:g} s within these limits tells the base parameters apart, expected wider limits, "
                    "above all of velocity and acceleration",
                    limits.duration));
  }
  throw ConfigError(
      fmt::format("payload: no motion of {:g} s within these limits tells mass and centre of what {} carries, expected "
                  "wider limits, or a body that more joints carry",
                  limits.duration, limits.payload));
}

DrawnSeries drawSeries(Search& search, std::uint64_t seed) {
  const CounterRandom random(seed);
  DrawnSeries series;
  for (; series.draws < kSeriesDrawn && std::ssize(series.kept) < kSeriesKept; ++series.draws) {
    const std::vector<double> x = drawn(random, search.unknowns(), static_cast<std::uint32_t>(series.draws));
    const FourierMotion motion = search.motionOf(x);
    const double cost = search.cost(motion);
    if (cost < kBroken) {
      series.kept.push_back(motion);
      series.precisions.push_back(search.precision());
    }
    if (cost < series.lowest) {
      series.lowest = cost;
      series.best = x;
    }
    stopIfInterrupted();
  }
  return series;
}

}  // namespace

Excitation exciteRobot(const ArmModel& arm, const FrictionLaw& law, const ExcitationLimits& limits, std::uint64_t seed,
                       const std::function<void(double share)>& news) {
  Search search(arm, law, limits);
  DrawnSeries series = drawSeries(search, seed);
  std::vector<double> best = series.best;
  double lowest = series.lowest;
  const auto moved = [&](const std::vector<double>& x) {
    std::vector<double> there = series.best;
    for (std::size_t i = 0; i < there.size(); ++i) there[i] += x[i];
    return there;
  };
  CmaEsOptions options{.generations = kGenerations, .step = 0.5, .seed = seed};
  options.population = std::max(16, 4 + static_cast<int>(3.0 * std::log(static_cast<double>(search.unknowns()))));
  int generation = 0;
  minimiseByCmaEs([&](const std::vector<double>& x) { return search.cost(search.motionOf(moved(x))); },
                  search.unknowns(), options,
                  [&](const CmaEsGeneration& now) {
                    if (now.best_objective < lowest) {
                      lowest = now.best_objective;
                      best = moved(now.best);
                    }
                    if (news) news(static_cast<double>(++generation) / kGenerations);
                    return interruptRequested();
                  });
  stopIfInterrupted();
  if (lowest >= kBroken) refuseSearch(limits, lowest);
  const FourierMotion motion = search.motionOf(best);
  search.cost(motion);
  auto [reached, nearest] = search.reached(motion);
  return {motion,
          search.precision(),
          series.draws,
          std::move(series.kept),
          std::move(series.precisions),
          std::move(reached),
          std::move(nearest),
          search.names(),
          search.units()};
}

}  // namespace simgap
