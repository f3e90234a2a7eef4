#include "turns.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "simgap/core/decompositions.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

std::ptrdiff_t countKept(const std::vector<bool>& keep) { return std::ranges::count(keep, true); }

constexpr Eigen::Index kPowers = 6;  // of time, by which the load is told around a turn: 1, t … t^5

/// What one turn says of a shape of friction, the load's part taken out of both.
struct TurnSums {
  double squares = 0.0, product = 0.0;  ///< of the shape, and with the effort
};

/// The rows around one turn.
struct AroundTurn {
  Eigen::ArrayXd travel, effort;  ///< [rad] since the turn, negative before it; effort against the new direction
  Eigen::MatrixXd load;           ///< shape (rows, kPowers), orthonormal

  /// \param scale  [rad] x_s; 0: friction is there at once
  TurnSums sums(double scale) const {
    Eigen::VectorXd shape = (travel >= 0.0).cast<double>().matrix();
    if (scale > 0.0) shape.array() *= 1.0 - (-travel.max(0.0) / scale).exp();
    shape -= load * (load.transpose() * shape);
    return {shape.squaredNorm(), shape.dot(effort.matrix())};
  }
};

/// \param time  shape (rows), within [-1, 1]
Eigen::MatrixXd orthonormalPowers(const Eigen::ArrayXd& time) {
  Eigen::MatrixXd columns(time.size(), kPowers);
  columns.col(0).setOnes();
  for (Eigen::Index k = 1; k < kPowers; ++k) columns.col(k) = columns.col(k - 1).array() * time;
  for (Eigen::Index k = 0; k < kPowers; ++k) {
    for (int twice = 0; twice < 2; ++twice) {
      for (Eigen::Index j = 0; j < k; ++j) columns.col(k) -= columns.col(j) * columns.col(j).dot(columns.col(k));
    }
    columns.col(k).normalize();
  }
  return columns;
}

/// Without the rows in which the joint stood before it turned: friction is anything within its limits there.
std::vector<std::size_t> rowsAround(const TurningJoint& joint, std::size_t turn, const Block& run,
                                    const MotionSign& sign, double seconds) {
  const auto goesOn = [&](std::size_t i, std::size_t as) {
    return sign.direction[i] == sign.direction[as] && std::abs(joint.time[i] - joint.time[turn]) <= seconds;
  };
  std::size_t begin = turn, end = turn;
  while (begin > run.begin && goesOn(begin - 1, turn - 1)) --begin;
  while (end < run.end && goesOn(end, turn)) ++end;
  std::vector<std::size_t> rows;
  for (std::size_t i = begin; i < end; ++i) {
    if (i >= turn || joint.position[i] != joint.position[i + 1]) rows.push_back(i);
  }
  return rows;
}

std::vector<AroundTurn> rowsAroundTurns(const TurningJoint& joint, std::span<const std::size_t> turns,
                                        std::span<const Block> runs, const MotionSign& sign, double seconds) {
  constexpr std::size_t kFewestRows = 2 * kPowers;
  std::vector<AroundTurn> all;
  for (const std::size_t turn : turns) {
    const auto run = std::ranges::find_if(runs, [&](const Block& b) { return turn >= b.begin && turn < b.end; });
    const std::vector<std::size_t> rows = rowsAround(joint, turn, *run, sign, seconds);
    if (rows.size() < kFewestRows) continue;
    const double direction = sign.direction[turn];
    const double from = std::min(direction * joint.position[turn], direction * joint.position[turn - 1]);
    const auto n = static_cast<Eigen::Index>(rows.size());
    AroundTurn around{Eigen::ArrayXd(n), Eigen::ArrayXd(n), {}};
    Eigen::ArrayXd time(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const std::size_t i = rows[k];
      around.travel[k] = i < turn ? -1.0 : std::max(0.0, direction * joint.position[i] - from);
      around.effort[k] = direction * joint.effort[i];
      time[k] = (joint.time[i] - joint.time[turn]) / seconds;
    }
    around.load = orthonormalPowers(time);
    all.push_back(std::move(around));
  }
  return all;
}

/// Friction of one size at all turns, and how it comes.
struct BuildUp {
  std::vector<TurnSums> turns;
  double size = 0.0;  ///< A

  BuildUp(const std::vector<AroundTurn>& around, double scale) {
    double squares = 0.0, product = 0.0;
    for (const AroundTurn& turn : around) {
      turns.push_back(turn.sums(scale));
      squares += turns.back().squares;
      product += turns.back().product;
    }
    if (squares > 0.0) size = product / squares;
  }
  /// What it explains of a turn's squared effort.
  double explains(std::size_t turn) const { return size * (2.0 * turns[turn].product - size * turns[turn].squares); }
};

/// What the first explains more than the second: of all turns, and that over its deviation from turn to turn.
struct Advantage {
  double gain = 0.0, clearness = 0.0;

  Advantage(const BuildUp& first, const BuildUp& second) {
    Eigen::ArrayXd gains(std::ssize(first.turns));
    for (std::size_t k = 0; k < first.turns.size(); ++k) gains[k] = first.explains(k) - second.explains(k);
    gain = gains.sum();
    const double scatter = (gains - gains.mean()).square().sum();
    if (scatter > 0.0) clearness = gain / std::sqrt(scatter);
  }
};

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

void leaveOutTurns(std::span<const double> time, std::span<const Block> runs, double blurred_seconds,
                   MotionSign& sign) {
  std::vector<std::size_t> places = turnsOf(sign.direction, runs);
  for (const Block& run : runs) places.insert(places.end(), {run.begin, run.end - 1});
  const auto left = [&](double share) {
    std::vector<bool> keep = sign.keep;
    for (const std::size_t place : places) {
      const auto run = std::ranges::find_if(runs, [&](const Block& b) { return place >= b.begin && place < b.end; });
      const double beside = share * blurred_seconds;
      for (std::size_t k = place; k-- > run->begin && time[place] - time[k] <= beside;) keep[k] = false;
      for (std::size_t k = place; k < run->end && time[k] - time[place] <= beside; ++k) keep[k] = false;
    }
    return keep;
  };
  constexpr double kLeastShare = 1.0 / 64.0;
  for (double share = 1.0; share > kLeastShare; share *= 0.8) {
    std::vector<bool> keep = left(share);
    if (2 * countKept(keep) < countKept(sign.keep)) continue;  // it turns so often that a smaller margin has to do
    sign.keep = std::move(keep);
    return;
  }
}

double travelOfFriction(const TurningJoint& joint, std::span<const std::size_t> turns, std::span<const Block> runs,
                        const MotionSign& sign, double seconds) {
  constexpr std::size_t kFewestTurns = 6;
  constexpr double kClear = 4.0;                                     // deviations of a gain, from turn to turn
  constexpr double kBuiltUp = 4.6;                                   // ln 100: of the way a hundredth is left
  constexpr double kFinest = 1e5, kFewestScales = 3.0, kStep = 1.3;  // x_s: parts of the usual travel after a turn
  constexpr double kHarmful = 20.0;                                  // likewise: it passes for a delay or for drag
  if (turns.empty()) return 0.0;
  const std::vector<AroundTurn> around = rowsAroundTurns(joint, turns, runs, sign, seconds);
  if (around.size() < kFewestTurns) return kUntold;
  std::vector<double> travels;
  for (const AroundTurn& turn : around) travels.push_back(turn.travel.maxCoeff());
  const double far = upperMedian(std::move(travels));
  if (!(far > 0.0)) return 0.0;  // the position goes the other way
  const BuildUp at_once(around, 0.0);
  const bool told = Advantage(at_once, BuildUp(around, far / kHarmful)).clearness > kClear;
  double best = 0.0, most = 0.0;
  for (double scale = far / kFinest; scale <= far / kFewestScales; scale *= kStep) {
    const BuildUp built(around, scale);
    if (built.size <= 0.0) continue;  // friction that falls builds up nothing
    const Advantage over(built, at_once);
    if (over.gain <= most || (told && over.clearness < kClear)) continue;
    most = over.gain;
    best = scale;
  }
  return told ? kBuiltUp * best : std::max(kUntold, kBuiltUp * best);
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
