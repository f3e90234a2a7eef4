#include "turns.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "simgap/core/decompositions.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr double kBlurred = 0.5;  // periods of the smoother's bandwidth, on either side

std::ptrdiff_t countKept(const std::vector<bool>& keep) { return std::ranges::count(keep, true); }

/// What one turn says: the parabola's part taken out of both.
struct TurnSums {
  double squares = 0.0, product = 0.0;  ///< of the shape, and with the effort
};

/// The rows after one turn.
struct AfterTurn {
  Eigen::ArrayXd travel, effort;  ///< [rad], as it stands against the new direction
  Eigen::MatrixXd parabola;       ///< shape (rows, 3), orthonormal

  TurnSums sums(double scale) const {
    Eigen::VectorXd shape = (-travel / scale).exp().matrix(), torque = effort.matrix();
    shape -= parabola * (parabola.transpose() * shape);
    torque -= parabola * (parabola.transpose() * torque);
    return {shape.squaredNorm(), shape.dot(torque)};
  }
};

Eigen::MatrixXd orthonormalParabola(const Eigen::ArrayXd& time) {
  Eigen::MatrixXd columns(time.size(), 3);
  columns << Eigen::MatrixXd::Ones(time.size(), 1), time.matrix(), time.square().matrix();
  for (Eigen::Index k = 0; k < 3; ++k) {
    for (int twice = 0; twice < 2; ++twice) {
      for (Eigen::Index j = 0; j < k; ++j) columns.col(k) -= columns.col(j) * columns.col(j).dot(columns.col(k));
    }
    columns.col(k).normalize();
  }
  return columns;
}

std::vector<AfterTurn> rowsAfterTurns(const TurningJoint& joint, std::span<const std::size_t> turns,
                                      std::span<const Block> runs, const MotionSign& sign, double seconds) {
  constexpr std::size_t kFewestRows = 8;
  std::vector<AfterTurn> all;
  for (const std::size_t turn : turns) {
    const auto run = std::ranges::find_if(runs, [&](const Block& b) { return turn >= b.begin && turn < b.end; });
    std::size_t end = turn;
    while (end < run->end && sign.direction[end] == sign.direction[turn] &&
           joint.time[end] - joint.time[turn] <= seconds) {
      ++end;
    }
    if (end - turn < kFewestRows) continue;
    const double direction = sign.direction[turn];
    const double from = direction * joint.position[turn], before = direction * joint.position[turn - 1];
    AfterTurn after{Eigen::ArrayXd(end - turn), Eigen::ArrayXd(end - turn), {}};
    Eigen::ArrayXd time(end - turn);
    for (std::size_t i = turn; i < end; ++i) {
      const auto k = static_cast<Eigen::Index>(i - turn);
      after.travel[k] = std::max(0.0, direction * joint.position[i] - std::min(from, before));
      after.effort[k] = direction * joint.effort[i];
      time[k] = (joint.time[i] - joint.time[turn]) / seconds;
    }
    after.parabola = orthonormalParabola(time);
    all.push_back(std::move(after));
  }
  return all;
}

/// Of A its square over its variance from turn to turn; 0 where friction falls: that is none that builds up.
double squaredClearness(const std::vector<AfterTurn>& after, double scale) {
  double squares = 0.0, product = 0.0, scatter = 0.0;
  std::vector<TurnSums> sums;
  for (const AfterTurn& turn : after) {
    sums.push_back(turn.sums(scale));
    squares += sums.back().squares;
    product += sums.back().product;
  }
  if (!(squares > 0.0) || product >= 0.0) return 0.0;
  for (const TurnSums& s : sums) scatter += std::pow(s.product - product / squares * s.squares, 2);
  return scatter > 0.0 ? product * product / scatter : 0.0;
}

}  // namespace

std::vector<std::size_t> turnsOf(std::span<const signed char> direction, std::span<const Block> runs) {
  std::vector<std::size_t> turns;
  for (const Block& run : runs) {
    for (std::size_t i = run.begin + 1; i < run.end; ++i) {
      if (direction[i - 1] != 0 && direction[i] != direction[i - 1]) turns.push_back(i);
    }
  }
  return turns;
}

void leaveOutTurns(std::span<const double> time, std::span<const Block> runs, double bandwidth, MotionSign& sign) {
  const std::vector<std::size_t> turns = turnsOf(sign.direction, runs);
  const auto left = [&](double share) {
    std::vector<bool> keep = sign.keep;
    for (const std::size_t turn : turns) {
      const auto run = std::ranges::find_if(runs, [&](const Block& b) { return turn >= b.begin && turn < b.end; });
      const double beside = share * kBlurred / bandwidth;
      for (std::size_t k = turn; k-- > run->begin && time[turn] - time[k] <= beside;) keep[k] = false;
      for (std::size_t k = turn; k < run->end && time[k] - time[turn] <= beside; ++k) keep[k] = false;
    }
    return keep;
  };
  constexpr double kLeastShare = 1.0 / 64.0;
  for (double share = 1.0; share > kLeastShare; share *= 0.5) {
    std::vector<bool> keep = left(share);
    if (2 * countKept(keep) < countKept(sign.keep)) continue;  // it turns so often that a smaller margin has to do
    sign.keep = std::move(keep);
    return;
  }
}

double travelOfFriction(const TurningJoint& joint, std::span<const std::size_t> turns, std::span<const Block> runs,
                        const MotionSign& sign, double seconds) {
  constexpr std::size_t kFewestTurns = 6;
  constexpr double kClear = 4.0;                                     // deviations of A, from turn to turn
  constexpr double kBuiltUp = 4.6;                                   // ln 100: of the way a hundredth is left
  constexpr double kFinest = 1e5, kFewestScales = 3.0, kStep = 1.3;  // x_s: parts of the usual travel after a turn
  const std::vector<AfterTurn> after = rowsAfterTurns(joint, turns, runs, sign, seconds);
  if (after.size() < kFewestTurns) return 0.0;
  std::vector<double> travels;
  for (const AfterTurn& turn : after) travels.push_back(turn.travel.maxCoeff());
  const double far = upperMedian(std::move(travels));
  double best = 0.0, clearest = kClear * kClear;
  for (double scale = far / kFinest; scale <= far / kFewestScales; scale *= kStep) {
    const double clear = squaredClearness(after, scale);
    if (clear <= clearest) continue;
    clearest = clear;
    best = scale;
  }
  return kBuiltUp * best;
}

void leaveOutFirstTravel(std::span<const double> position, std::span<const double> velocity,
                         std::span<const Block> runs, double slow, double travel, MotionSign& sign) {
  std::vector<double> since(position.size(), 0.0), kept;
  for (const Block& run : runs) {
    double from = position[run.begin];
    for (std::size_t i = run.begin; i < run.end; ++i) {
      const bool turns = i > run.begin && sign.direction[i] != sign.direction[i - 1];
      if (turns || std::abs(velocity[i]) <= slow) from = position[i];
      since[i] = std::abs(position[i] - from);
      if (sign.keep[i]) kept.push_back(since[i]);
    }
  }
  if (kept.empty()) return;
  const double most = std::min(travel, upperMedian(std::move(kept)));
  for (std::size_t i = 0; i < since.size(); ++i) sign.keep[i] = sign.keep[i] && since[i] >= most;
}

}  // namespace simgap
