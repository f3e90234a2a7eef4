/// \file
/// A log made ready for models and effects (simgap/model/effects/actuator_effect.h): all rows stay, in order, with a
/// mark on those that mean nothing.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/measure/logs/actuator_rows.h"
#include "simgap/measure/logs/friction_rows.h"
#include "simgap/measure/logs/log_table.h"
#include "simgap/optimize/least_squares.h"

namespace simgap {

/// The weight of a pendulum whose angle offset theta_0 is fitted.
struct RigAngle {
  Eigen::ArrayXd sine, cosine;  ///< shape (n): load at theta_0 = 0 and pi / 2, per unit of what is fitted of m l
  double start = 0.0;           ///< [rad] theta_0 to begin with
  bool scaled = false;          ///< mass or length is fitted, too, and multiplies it; otherwise it is known load

  Eigen::ArrayXd load(double offset) const { return std::cos(offset) * sine + std::sin(offset) * cosine; }
};

/// A log with its rows' meaning.
struct ActuatorData {
  ActuatorRows rows;
  std::vector<bool> keep;                     ///< shape (n): rows that count
  std::vector<bool> effort_lost;              ///< shape (n): rows without an effort, whose motion is known; or empty
  Eigen::ArrayXXd rig;                        ///< shape (n, R): load per unit of each fitted constant of the rig
  std::vector<ParameterSpec> rig_parameters;  ///< shape (R)
  std::optional<RigAngle> angle;  ///< scaled: the first column of `rig`, else part of `rows.load`, both at its start
  bool fits_weight = false;       ///< as FrictionData
  double load_noise = 0.0;        ///< as FrictionData
  bool offset = false;            ///< the model has a current offset of its own
  std::string load_unit = "Nm", effort_unit = "A", velocity_unit = "rad_s";
};

/// A column of the log that is none of the model's channels, or a channel by name.
struct ContextChannel {
  std::string name;
  Eigen::ArrayXd values;  ///< shape (n)
};

struct PreparedLog {
  ActuatorKind kind{};
  ActuatorData data;
  std::vector<Block> blocks;            ///< of 4 to 20 s, shorter in short logs; held out together
  std::vector<ContextChannel> context;  ///< in the order of ActuatorRows::context
  std::vector<std::string> session_names;
  std::string file, effort_column;
  double dead_band = 0.0;
  double blurred_seconds = 0.0;  ///< about a turn of motion: there its derivatives are the smoother's; 0: none smoothed
  std::vector<ChannelSpikes> spikes;   ///< samples that stood alone; their rows do not count
  std::vector<ChannelSpikes> clipped;  ///< of a spring: a sensor at its limit; likewise
  std::vector<LeftOutRows> left_out;   ///< rows of the file that are none of the log's, as readLogTable
  std::vector<std::string> warnings;
};

/// As a model of that kind sees it; the rig's bandwidth and ratio replace those of `options`.
PreparedLog prepareLog(const CsvTable& table, const Bench& bench, ActuatorKind kind, FrictionDataOptions options = {});

/// The same rows to explain the joint's angle by the motor's; the log must have both.
PreparedLog prepareTransmissionData(const PreparedLog& drive);

}  // namespace simgap
