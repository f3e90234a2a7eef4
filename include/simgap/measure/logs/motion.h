/// \file
/// What is derived from measured motion: the direction friction acts against, and velocity and acceleration of logs
/// that hold positions only.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "simgap/core/blocks.h"

namespace simgap {

/// The direction of motion of every row.
struct MotionSign {
  std::vector<signed char> direction;  ///< shape (rows): +1 or -1, 0 before the first motion
  std::vector<bool> keep;              ///< shape (rows): false before the first motion and at reversals
  double dead_band = 0.0;              ///< [velocity's unit] within which the sign was held
  std::size_t reversals = 0;
};

/// Friction keeps its sign while a drive rests, but the sign of a noisy velocity near 0 is a coin: the last direction
/// is held through a dead band of `widths` noise levels and changes at the turning point of travel, once two rows in a
/// row are outside the band on the other side, or one is by as much again. Rows before the
/// first motion and one row on each side of a reversal are left out.
/// \param velocity  shape (rows).  \param widths  half width of the dead band in noise levels of the velocity.
/// \param dead_band  half width itself, when it is known.
MotionSign holdSign(std::span<const double> velocity, double widths = 3.5,
                    std::optional<double> dead_band = std::nullopt);

/// sign(velocity) of each row as it stands, every row kept: what 003 did.
MotionSign rawSign(std::span<const double> velocity);

/// Zero-phase low-pass filter for unevenly sampled values: the smoothing spline of third differences (Whittaker 1923),
/// whose gain 1 / (1 + (f / bandwidth)^6) is that of a third-order Butterworth filter run forwards and backwards.
/// \param time  [s] rising, shape (n).  \param bandwidth  [Hz] at which the gain is 1/2.
std::vector<double> smooth(std::span<const double> time, std::span<const double> values, double bandwidth);

/// The runs of a log over which values may be smoothed: sessions, apart where nothing was logged for eight usual steps
/// and longer. \param time  [s], \param session  shape (n).
std::vector<Block> splitRuns(std::span<const double> time, std::span<const int> session);

/// Values that are smoothed to `bandwidth` [Hz] run by run, shape (rows); as they are in runs of fewer than 4 rows.
std::vector<double> smoothRuns(std::span<const double> time, std::span<const double> values,
                               std::span<const Block> runs, double bandwidth);

/// Rows per second within runs [Hz]. \param runs  as splitRuns; 0 when none has two rows.
double samplingRate(std::span<const double> time, std::span<const Block> runs);

/// The bandwidth for `smooth` at which values, and so their derivatives, come nearest to the truth: the lowest
/// generalised cross-validation error (Craven & Wahba 1979). Quantisation is white noise only where a row is a count
/// and more from the next: slower channels are judged on every k-th row. At even speed it may repeat slowly even then;
/// where the smoothest curve that rounding off alone explains (Morozov 1966) is far smoother, that one is taken.
/// \param runs  as splitRuns.  \param highest  [Hz] that is returned at most, and for too few rows.
double smoothingBandwidth(std::span<const double> time, std::span<const double> values, std::span<const Block> runs,
                          double highest);

/// d values / d time: of the polynomial through five rows where their steps are alike, else of three; one-sided at the
/// ends. Shape (n), n >= 2.
std::vector<double> differentiate(std::span<const double> time, std::span<const double> values);

}  // namespace simgap
