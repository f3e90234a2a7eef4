#include <algorithm>
#include <cmath>
#include <numbers>

#include "simgap/core/statistics.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

constexpr std::size_t kFewestRowsOfPiece = 60;
constexpr std::size_t kMargin = 8;    // one in so many rows of a piece, at either end, is smoothed from one side only
constexpr double kUsable = 0.45;      // of the sampling rate
constexpr double kLadder = 1.4;       // between bandwidths tried: the optimum is broad
constexpr double kFewestPeriods = 8;  // of a bandwidth within a piece

/// A stretch of a channel, thinned out.
struct Piece {
  std::vector<double> time, values;
  double step() const { return (time.back() - time.front()) / static_cast<double>(time.size() - 1); }
};

/// Every how many rows a channel goes on by a count: nearer rows are rounded off alike.
std::size_t rowsPerCount(std::span<const double> values, std::span<const Block> runs, double quantum) {
  double travel = 0.0, rows = 0.0;
  for (const Block& run : runs) {
    for (std::size_t i = run.begin + 1; i < run.end; ++i) travel += std::abs(values[i] - values[i - 1]);
    rows += static_cast<double>(run.size() - 1);
  }
  if (travel == 0.0) return 1;
  return static_cast<std::size_t>(std::ceil(std::max(1.0, quantum * rows / travel)));
}

/// Some stretches from all over the log: what is asked of them does not need every row.
std::vector<Piece> piecesOf(std::span<const double> time, std::span<const double> values, std::span<const Block> runs,
                            std::size_t stride) {
  constexpr std::size_t kRows = 8000, kMostRows = 24000;
  std::vector<Block> all;
  for (const Block& run : runs) {
    for (std::size_t begin = run.begin; begin < run.end; begin += kRows * stride) {
      const Block piece{begin, std::min(run.end, begin + kRows * stride)};
      if (piece.size() >= kFewestRowsOfPiece * stride) all.push_back(piece);
    }
  }
  std::vector<Piece> pieces;
  std::size_t rows_of_all = 0;
  for (const Block& piece : all) rows_of_all += piece.size() / stride;
  const std::size_t count =
      std::min(all.size(), std::max<std::size_t>(1, all.size() * kMostRows / std::max(rows_of_all, kMostRows)));
  for (std::size_t k = 0; k < count; ++k) {
    const Block& rows = all[(2 * k + 1) * all.size() / (2 * count)];
    Piece& piece = pieces.emplace_back();
    for (std::size_t i = rows.begin; i < rows.end; i += stride) {
      piece.time.push_back(time[i]);
      piece.values.push_back(values[i]);
    }
  }
  return pieces;
}

/// Mean gain of `smooth` over all frequencies: the share of the rows that its result is free to follow.
double meanGain(double bandwidth, double step) {
  constexpr int kAngles = 1000;
  const double weight =
      std::pow(2.0 * std::sin(std::min(std::numbers::pi * bandwidth * step, 0.5 * std::numbers::pi)), -6);
  double sum = 0.0;
  for (int k = 0; k < kAngles; ++k) {
    const double angle = std::numbers::pi * (k + 0.5) / kAngles;
    sum += 1.0 / (1.0 + weight * std::pow(2.0 * std::sin(0.5 * angle), 6));
  }
  return sum / kAngles;
}

/// The share of the rows in which a channel moves: elsewhere rounding off is no noise.
double movingShare(const std::vector<Piece>& pieces) {
  constexpr std::size_t kRows = 4;  // of which one at least brings another count
  double moving = 0.0, rows = 0.0;
  for (const Piece& piece : pieces) {
    for (std::size_t i = kRows; i < piece.values.size(); ++i) {
      moving += piece.values[i] != piece.values[i - kRows] ? 1.0 : 0.0;
      rows += 1.0;
    }
  }
  return moving / rows;
}

/// What a bandwidth leaves of the pieces, stretch by stretch.
struct Stretches {
  std::vector<double> squares, rows, free;  ///< of the residual; all; that the smoothed values can follow

  Stretches(const std::vector<Piece>& pieces, double bandwidth) {
    constexpr std::size_t kLength = 250;
    for (const Piece& piece : pieces) {
      const std::vector<double> smoothed = smooth(piece.time, piece.values, bandwidth);
      const double gain = meanGain(bandwidth, piece.step());
      const std::size_t margin = smoothed.size() / kMargin, end = smoothed.size() - margin;
      for (std::size_t begin = margin; begin < end; begin += kLength) {
        const std::size_t stop = std::min(end, begin + kLength);
        double sum = 0.0;
        for (std::size_t i = begin; i < stop; ++i) sum += std::pow(piece.values[i] - smoothed[i], 2);
        squares.push_back(sum);
        rows.push_back(static_cast<double>(stop - begin));
        free.push_back(gain * rows.back());
      }
    }
  }

  /// All but stretches that outweigh nearly all others even with the least smoothing: an outlier that nobody put right.
  std::vector<bool> inliers() const {
    constexpr double kMost = 0.95, kFar = 4.0;
    std::vector<double> sizes;
    for (std::size_t k = 0; k < squares.size(); ++k) sizes.push_back(squares[k] / rows[k]);
    const double limit = kFar * quantile(sizes, kMost);
    std::vector<bool> keep;
    for (const double size : sizes) keep.push_back(size <= limit);
    return keep;
  }
};

struct Trial {
  double bandwidth, score, residual;  ///< score: cross-validation error, residual: RMS of the noise it stands for
};

Trial judge(const Stretches& stretches, const std::vector<bool>& keep, double bandwidth) {
  double squares = 0.0, rows = 0.0, free = 0.0;
  for (std::size_t k = 0; k < keep.size(); ++k) {
    if (!keep[k]) continue;
    squares += stretches.squares[k];
    rows += stretches.rows[k];
    free += stretches.free[k];
  }
  const double left = 1.0 - free / rows;
  return {bandwidth, squares / (left * left), std::sqrt(squares / rows / left)};
}

}  // namespace

double smoothingBandwidth(std::span<const double> time, std::span<const double> values, std::span<const Block> runs,
                          double highest) {
  constexpr double kSlack = 1.05, kFarApart = 2.5;
  const double quantum = quantumOf(values);
  const std::size_t stride = rowsPerCount(values, runs, quantum);
  const std::vector<Piece> pieces = piecesOf(time, values, runs, stride);
  if (pieces.empty()) return highest;
  double step = 0.0, seconds = 0.0;
  for (const Piece& piece : pieces) {
    step = std::max(step, piece.step());
    seconds = std::max(seconds, piece.time.back() - piece.time.front());
  }
  std::vector<Trial> trials;
  std::vector<bool> keep;
  for (double b = std::min(highest, kUsable / step); b * seconds >= kFewestPeriods; b /= kLadder) {
    const Stretches stretches(pieces, b);
    if (trials.empty()) keep = stretches.inliers();
    trials.push_back(judge(stretches, keep, b));
  }
  if (trials.empty()) return highest;
  const Trial& best = *std::ranges::min_element(trials, {}, &Trial::score);
  const double rounding = kSlack * quantum * std::sqrt(movingShare(pieces) / 12.0);
  const auto smoothest =
      std::ranges::find_if(trials.rbegin(), trials.rend(), [&](const Trial& t) { return t.residual < rounding; });
  if (smoothest == trials.rend() || best.bandwidth < kFarApart * smoothest->bandwidth) return best.bandwidth;
  return smoothest->bandwidth;
}

}  // namespace simgap
