#include "simgap/fit/actuators/bench_protocol.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>

#include "simgap/core/csv.h"
#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/model/actuator/friction_drive.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kMotionsDrawn = 600;
constexpr std::size_t kMotionsAtOnce = 10;  // prepared together, as sessions of one log
constexpr std::size_t kRandomProtocols = 100;
constexpr int kExchangeRounds = 20;
constexpr double kWithinLimit = 0.99;  // of load and current: between two rows they go a little further
constexpr double kTellsNothing = 1e-12;
constexpr double kSlowestShare = 1e-3;  // of the largest velocity, and of the Stribeck velocity a quarter
constexpr double kLongestRest = 3.0;    // [s]
constexpr std::uint32_t kMotionPurpose = 41, kProtocolPurpose = 42;

/// A motion within the joint's limits, whatever the numbers are.
BenchMotion drawMotion(const DriveLimits& limits, const CounterRandom& random, std::size_t individual) {
  const auto draw = [&](std::uint32_t parameter) {
    return random.uniform({0, static_cast<std::uint32_t>(individual), parameter, kMotionPurpose});
  };
  BenchMotion motion{};
  const double half = 0.5 * (limits.upper - limits.lower);
  motion.kind = draw(0) < 0.5 ? BenchMotion::Kind::kSine : BenchMotion::Kind::kMoves;
  motion.amplitude = half * (0.05 + 0.95 * draw(1));
  motion.middle = limits.lower + motion.amplitude + 2.0 * (half - motion.amplitude) * draw(2);
  const double stribeck = limits.guess.valueOr("v_s", kInfinity) / limits.ratio;
  const double slowest = std::max(kSlowestShare * limits.velocity, std::min(0.25 * stribeck, 0.1 * limits.velocity));
  const bool sine = motion.kind == BenchMotion::Kind::kSine;
  // A sinusoid's largest acceleration is v^2 / A; moves have to reach their speed halfway.
  const double fastest =
      std::min(limits.velocity, std::sqrt((sine ? 1.0 : 2.0) * limits.acceleration * motion.amplitude));
  motion.speed = std::min(slowest, fastest) * std::pow(fastest / std::min(slowest, fastest), draw(3));
  motion.acceleration = sine ? motion.speed * motion.speed / motion.amplitude : limits.acceleration;
  motion.rest = sine || draw(4) < 0.5 ? 0.0 : kLongestRest * draw(5);
  motion.weight = std::min(static_cast<std::size_t>(draw(6) * static_cast<double>(limits.weights.size())),
                           limits.weights.size() - 1);
  return motion;
}

/// Load of a weight on the lever [N m].
double loadOf(const DriveLimits& limits, const BenchMotion& motion, const BenchMotion::State& s) {
  const LeverWeight& weight = limits.weights[motion.weight];
  return weight.mass * weight.length *
         (Bench().gravity * std::sin(s.angle - limits.hangs) + weight.length * s.acceleration);
}

/// What one session tells.
struct Information {
  BenchMotion motion;
  MatrixXd plain, correlated;  ///< J^T J and J^T Omega J, shape (P, P)
  bool within = false;         ///< the limits of load and current
};

/// Sessions as the rows of a log that was recorded without noise.
class NoiselessLog {
 public:
  NoiselessLog(const DriveLimits& limits, const ActuatorModel& subject, std::span<const BenchMotion> motions)
      : log_(prepare(limits, motions)) {
    for (const ActuatorEffect* effect : subject.effects) requireChannels(*effect);
    regression_.emplace(subject.base, subject.effects, log_.data, subject.presliding());
    theta_ = regression_->thetaOf(subject.values);
    current_ = regression_->predict(theta_);
  }

  const ActuatorRegression& regression() const { return *regression_; }
  const std::vector<double>& theta() const { return theta_; }
  const ArrayXd& load() const { return log_.data.rows.load; }
  const ArrayXd& current() const { return current_; }

  /// Derivatives of the current, shape (rows, P); 0 at rest and in rows that no fit takes.
  MatrixXd derivatives() const {
    VectorXd residual;
    MatrixXd jacobian;
    regression_->evaluate(theta_, residual, &jacobian);
    for (Index i = 0; i < jacobian.rows(); ++i) {
      if (std::abs(log_.data.rows.speed[i]) < 1e-9) jacobian.row(i).setZero();
    }
    return jacobian;
  }

 private:
  static PreparedLog prepare(const DriveLimits& limits, std::span<const BenchMotion> motions) {
    const FrictionLaw& law = friction::find(limits.guess.law);
    const DriveFeedForward drive = feedForward(law, limits.guess.parameters);
    CsvWriter csv(
        {"time_s", "session", "motor_current_A", "motor_velocity_rad_s", "joint_position_rad", "external_torque_Nm"});
    for (std::size_t m = 0; m < motions.size(); ++m) {
      DirectionHold hold(0.0);
      for (std::size_t i = 0; i < limits.sessionRows(); ++i) {
        const double time = static_cast<double>(i) / limits.rate;
        const BenchMotion::State s = motions[m].at(time);
        const double load = loadOf(limits, motions[m], s), w = limits.ratio * s.velocity;
        csv.add(static_cast<double>(m) * limits.session + time).add(static_cast<double>(m));
        csv.add(drive.effort(load, w, hold.update(w))).add(w).add(s.angle).add(load).endRow();
      }
    }
    Bench bench;
    bench.ratio = limits.ratio;
    return prepareLog(CsvTable::parse(csv.text(), "protocol"), bench, ActuatorKind::kFriction);
  }

  void requireChannels(const ActuatorEffect& effect) const {
    for (const OptionalChannel channel : effect.needs) {
      if (channel == OptionalChannel::kRest || log_.data.rows.has(channel)) continue;
      throw ConfigError(fmt::format("causes: {} needs {}, which no protocol of motions and weights decides",
                                    effect.name, toString(channel)));
    }
  }

  PreparedLog log_;
  std::optional<ActuatorRegression> regression_;
  std::vector<double> theta_;
  ArrayXd current_;
};

/// Omega J for Omega_ij = memory^|i - j|: what is before a row, and what comes after it.
MatrixXd correlatedRows(const MatrixXd& jacobian, double memory) {
  MatrixXd before = jacobian, after = jacobian;
  for (Index i = 1; i < jacobian.rows(); ++i) before.row(i) += memory * before.row(i - 1);
  for (Index i = jacobian.rows() - 1; i-- > 0;) after.row(i) += memory * after.row(i + 1);
  return before + after - jacobian;
}

double logDeterminant(const MatrixXd& symmetric) {
  return symmetricEigen(symmetric).values.cwiseMax(kTellsNothing).array().log().sum();
}

class ProtocolSearch {
 public:
  ProtocolSearch(const DriveLimits& limits, std::uint64_t seed, const std::function<void(double)>& news)
      : limits_(limits), subject_(subjectOf(limits.guess)), random_(seed), news_(news) {
    for (const ActuatorEffect* effect : subject_.effects) {
      if (effect->contained_in == nullptr || !effect->contained_in(*subject_.base.law)) continue;
      throw ConfigError(fmt::format("causes: {} is part of the law {}, expected it in one of them", effect->name,
                                    subject_.base.law->name));
    }
    drawMotions();
    chooseParameters();
  }

  BenchProtocol find();

 private:
  void drawMotions();
  void chooseParameters();
  ProtocolPrecision precision(const MatrixXd& plain, const MatrixXd& correlated) const;
  double cost(const MatrixXd& plain, const MatrixXd& correlated) const {
    return (0.5 * logDeterminant(correlated) - logDeterminant(plain)) / static_cast<double>(free_.size());
  }
  std::vector<std::size_t> drawProtocol(std::size_t number) const;
  void exchange(std::vector<std::size_t>& chosen) const;
  MatrixXd sumOf(std::span<const std::size_t> chosen, MatrixXd Information::*which) const {
    MatrixXd sum = MatrixXd::Zero(std::ssize(free_), std::ssize(free_));
    for (const std::size_t m : chosen) sum += motions_[m].*which;
    return sum;
  }
  void fillRows(BenchProtocol& protocol) const;

  const DriveLimits& limits_;
  ActuatorModel subject_;
  CounterRandom random_;
  const std::function<void(double)>& news_;
  std::vector<Information> motions_;     ///< within the limits
  std::unique_ptr<NoiselessLog> first_;  ///< of the motions drawn first: which parameters there are
  std::vector<Index> free_, silent_;
  VectorXd scale_;  ///< of the free parameters: about their information's root
};

void ProtocolSearch::drawMotions() {
  motions_.resize(kMotionsDrawn);
  std::vector<BenchMotion> drawn;
  for (std::size_t m = 0; m < kMotionsDrawn; ++m) drawn.push_back(drawMotion(limits_, random_, m));
  const auto rows = static_cast<Index>(limits_.sessionRows());
  tbb::parallel_for(std::size_t{0}, kMotionsDrawn / kMotionsAtOnce, [&](std::size_t chunk) {
    stopIfInterrupted();
    const std::size_t first = chunk * kMotionsAtOnce;
    auto log = std::make_unique<NoiselessLog>(limits_, subject_, std::span(drawn).subspan(first, kMotionsAtOnce));
    const MatrixXd all = log->derivatives();
    for (std::size_t m = 0; m < kMotionsAtOnce; ++m) {
      const Index begin = static_cast<Index>(m) * rows;
      const MatrixXd jacobian = all.middleRows(begin, rows);
      Information& told = motions_[first + m];
      told.motion = drawn[first + m];
      told.plain = jacobian.transpose() * jacobian;
      told.correlated = jacobian.transpose() * correlatedRows(jacobian, limits_.memory);
      told.within = log->load().segment(begin, rows).abs().maxCoeff() <= kWithinLimit * limits_.torque &&
                    log->current().segment(begin, rows).abs().maxCoeff() <= kWithinLimit * limits_.current;
    }
    if (chunk == 0) first_ = std::move(log);
  });
  news_(0.7);
  std::erase_if(motions_, [](const Information& told) { return !told.within; });
  if (motions_.empty()) {
    throw ConfigError(
        fmt::format("found no motion of {} that keeps torque_Nm {:g} and current_A {:g} with these weights, "
                    "expected lighter weights or higher limits",
                    kMotionsDrawn, limits_.torque, limits_.current));
  }
}

void ProtocolSearch::chooseParameters() {
  VectorXd all = VectorXd::Zero(std::ssize(first_->regression().parameters()));
  for (const Information& told : motions_) all += told.plain.diagonal();
  for (Index i = 0; i < all.size(); ++i) {
    if (first_->regression().parameters()[i].fixed) continue;
    (all[i] > 0.0 ? free_ : silent_).push_back(i);
  }
  scale_ = (all(free_) / static_cast<double>(motions_.size())).cwiseSqrt().cwiseInverse();
  for (Information& told : motions_) {
    told.plain = (scale_.asDiagonal() * told.plain(free_, free_) * scale_.asDiagonal()).eval();
    told.correlated = (scale_.asDiagonal() * told.correlated(free_, free_) * scale_.asDiagonal()).eval();
  }
}

ProtocolPrecision ProtocolSearch::precision(const MatrixXd& plain, const MatrixXd& correlated) const {
  const SymmetricEigen eigen = symmetricEigen(plain);
  const MatrixXd inverse =
      eigen.vectors * eigen.values.cwiseMax(kTellsNothing).cwiseInverse().asDiagonal() * eigen.vectors.transpose();
  const MatrixXd scaled = limits_.noise * limits_.noise * (inverse * correlated * inverse);
  const auto count = std::ssize(first_->theta());
  MatrixXd covariance = MatrixXd::Zero(count, count);
  for (Index i = 0; i < std::ssize(free_); ++i) {
    for (Index j = 0; j < std::ssize(free_); ++j) covariance(free_[i], free_[j]) = scale_[i] * scaled(i, j) * scale_[j];
  }
  ProtocolPrecision precision;
  precision.expected = first_->regression().physical(first_->theta(), covariance);
  for (Estimate& e : precision.expected) {
    e.lower95 = e.value - kNormalQuantile * e.sd;
    e.upper95 = e.value + kNormalQuantile * e.sd;
  }
  precision.log_sd = cost(plain, correlated);
  return precision;
}

std::vector<std::size_t> ProtocolSearch::drawProtocol(std::size_t number) const {
  std::vector<std::size_t> chosen(limits_.sessions());
  for (std::size_t s = 0; s < chosen.size(); ++s) {
    const double u =
        random_.uniform({0, static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(s), kProtocolPurpose});
    chosen[s] = std::min(static_cast<std::size_t>(u * static_cast<double>(motions_.size())), motions_.size() - 1);
  }
  return chosen;
}

/// Puts the best motion in the place of each session in turn, until none becomes better.
void ProtocolSearch::exchange(std::vector<std::size_t>& chosen) const {
  MatrixXd plain = sumOf(chosen, &Information::plain), correlated = sumOf(chosen, &Information::correlated);
  double best = cost(plain, correlated);
  std::vector<double> costs(motions_.size());
  for (int round = 0; round < kExchangeRounds; ++round) {
    const double before = best;
    for (std::size_t& session : chosen) {
      stopIfInterrupted();
      const MatrixXd rest = plain - motions_[session].plain,
                     rest_correlated = correlated - motions_[session].correlated;
      tbb::parallel_for(std::size_t{0}, motions_.size(), [&](std::size_t m) {
        costs[m] = cost(rest + motions_[m].plain, rest_correlated + motions_[m].correlated);
      });
      const auto lowest = std::ranges::min_element(costs);
      if (!(*lowest < best)) continue;
      best = *lowest;
      session = static_cast<std::size_t>(lowest - costs.begin());
      plain = rest + motions_[session].plain;
      correlated = rest_correlated + motions_[session].correlated;
    }
    news_(0.7 + 0.3 * (round + 1) / kExchangeRounds);
    if (before - best < 1e-6) break;
  }
}

void ProtocolSearch::fillRows(BenchProtocol& protocol) const {
  const NoiselessLog log(limits_, subject_, protocol.sessions);
  const std::size_t rows = limits_.sessionRows();
  for (std::size_t s = 0; s < protocol.sessions.size(); ++s) {
    for (std::size_t i = 0; i < rows; ++i) {
      const double time = static_cast<double>(i) / limits_.rate;
      const BenchMotion::State state = protocol.sessions[s].at(time);
      protocol.time.push_back(static_cast<double>(s) * limits_.session + time);
      protocol.session.push_back(s);
      protocol.angle.push_back(state.angle);
      protocol.velocity.push_back(state.velocity);
      protocol.acceleration.push_back(state.acceleration);
    }
  }
  protocol.load.assign(log.load().begin(), log.load().end());
  protocol.current.assign(log.current().begin(), log.current().end());
}

BenchProtocol ProtocolSearch::find() {
  BenchProtocol protocol;
  protocol.drawn = kMotionsDrawn;
  protocol.within = motions_.size();
  std::vector<std::size_t> chosen;
  double lowest = kInfinity;
  for (std::size_t k = 0; k < kRandomProtocols; ++k) {
    const std::vector<std::size_t> drawn = drawProtocol(k);
    protocol.random.push_back(precision(sumOf(drawn, &Information::plain), sumOf(drawn, &Information::correlated)));
    if (protocol.random.back().log_sd >= lowest && !chosen.empty()) continue;
    lowest = protocol.random.back().log_sd;
    chosen = drawn;
  }
  exchange(chosen);
  // Weights are changed as seldom as can be; among equals slow motions come last.
  std::ranges::stable_sort(chosen, [&](std::size_t a, std::size_t b) {
    const BenchMotion &one = motions_[a].motion, &other = motions_[b].motion;
    return std::tuple(one.weight, -one.speed, a) < std::tuple(other.weight, -other.speed, b);
  });
  protocol.precision = precision(sumOf(chosen, &Information::plain), sumOf(chosen, &Information::correlated));
  for (const std::size_t m : chosen) protocol.sessions.push_back(motions_[m].motion);
  fillRows(protocol);
  for (const Index i : silent_) protocol.silent.push_back(first_->regression().parameters()[i].name);
  return protocol;
}

}  // namespace

BenchProtocol designProtocol(const DriveLimits& limits, std::uint64_t seed,
                             const std::function<void(double share)>& news) {
  return ProtocolSearch(limits, seed, news).find();
}

}  // namespace simgap
