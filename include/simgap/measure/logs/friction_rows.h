/// \file
/// A drive's log made ready for a friction fit: motion completed, direction held, load worked out from the rig, rows
/// that mean nothing left out, the rest split into blocks.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/measure/logs/bench.h"
#include "simgap/measure/logs/spikes.h"

namespace simgap {

struct FrictionDataOptions {
  bool raw_sign = false;            ///< sign(w) as measured (003) instead of the held one
  double dead_band_widths = 3.5;    ///< half width of the dead band in noise levels of the velocity
  std::optional<double> dead_band;  ///< [rad/s] instead: as a model file holds it
  std::optional<double> bandwidth;  ///< [Hz] of the smoothing; default: the bench's, else as suits the channel
  double block_seconds = 20.0;      ///< length of the blocks that are held out together
  bool load_is_fitted = false;      ///< instead of the effort: its noise bends nothing then, and it stays as measured
  bool all_rows = false;            ///< do not leave rows out, only mark them (FrictionData::keep)

  static constexpr double kDefaultBandwidth = 0.1;  ///< of the sampling rate: the highest that is chosen
};

/// Rows that take part, shape (n) each.
struct FrictionData {
  Eigen::ArrayXd time;                 ///< [s]
  Eigen::ArrayXd effort;               ///< what the motor drew
  Eigen::ArrayXd velocity;             ///< [rad/s] of the motor
  Eigen::ArrayXd log_speed;            ///< log |velocity|, bounded below
  Eigen::ArrayXd direction;            ///< +1 or -1, 0 where unknown (raw sign)
  Eigen::ArrayXd load;                 ///< [N m] known part
  Eigen::ArrayXXd load_per;            ///< shape (n, K): load per unit of each coefficient of the rig's unknown part
  std::vector<std::string> rig_names;  ///< shape (R): "mass", "length", "angle_offset", "inertia", "total_inertia"
  std::vector<std::string> rig_units;
  /// "angle_offset" is among them: the first two coefficients are A cos(theta_0) and A sin(theta_0), where A is the
  /// constant before it, or 1. Otherwise the coefficients are the constants.
  bool fits_angle = false;
  bool fits_weight = false;  ///< as Bench::fitsWeight; the first constant is the pendulum's mass or length
  std::vector<int> session;
  std::vector<Block> blocks;  ///< of block_seconds, for splits
  double block_seconds = 0.0;
  std::vector<std::size_t> row;  ///< of the log
  std::vector<bool> keep;        ///< with `all_rows`, shape (n): rows that mean something
  std::vector<std::string> session_names;
  std::string file, effort_name, effort_unit, angle_unit, velocity_unit, load_unit;
  double dead_band = 0.0;             ///< [rad/s]
  double bandwidth = 0.0;             ///< [Hz] of what was smoothed; 0 when nothing was
  double load_noise = 0.0;            ///< share of a smoothed load's variance that is noise still
  std::vector<std::string> derived;   ///< "velocity", "acceleration"
  std::vector<ChannelSpikes> spikes;  ///< samples that stood alone, by channel
  std::size_t log_rows = 0;
  std::size_t reversals = 0;
  bool timed = true;                  ///< the log has times; else rows may be steady states in any order
  std::vector<std::string> warnings;  ///< sentences about the log, for people

  std::size_t rows() const { return static_cast<std::size_t>(time.size()); }
  bool hasLoad() const { return load_per.cols() > 0 || (load != 0.0).any(); }
  /// Place of "angle_offset" among the rig's constants: 1 after a fitted amplitude, else 0.
  std::size_t angleIndex() const { return static_cast<std::size_t>(rig_names.front() != "angle_offset"); }

  /// \name The rig's constants, shape (R), and the coefficients of `load_per`, shape (K).
  ///@{
  Eigen::VectorXd rigCoefficients(std::span<const double> rig) const;
  std::vector<double> rigConstants(const Eigen::VectorXd& coefficients) const;
  Eigen::MatrixXd rigDerivatives(std::span<const double> rig) const;  ///< shape (K, R)
  Eigen::ArrayXd totalLoad(std::span<const double> rig) const;        ///< known and unknown part, shape (n)
  ///@}
};

/// \throws DataError when the log cannot answer at all: constant effort, no motion, implausible units, no load channel
///         and no bench, unknown sessions.
FrictionData prepareFrictionData(ActuatorLog log, const Bench& bench, const FrictionDataOptions& options);

/// The rows of `data` for which `keep` is true; blocks are cut accordingly. \param keep  shape (n).
FrictionData selectRows(const FrictionData& data, const std::vector<bool>& keep);

}  // namespace simgap
