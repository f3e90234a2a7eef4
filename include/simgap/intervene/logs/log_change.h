/// \file
/// What was done to a bench between two recordings, in physical words: `simgap/change/1` (docs/formats.md), of a drive,
/// winding, muscle or spring. One file of src/intervene/logs/changes per kind, found by CMake.
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/measure/logs/actuator_rows.h"
#include "simgap/measure/logs/bench.h"
#include "simgap/model/change_list.h"

namespace simgap {

/// The bench as the models have to see it.
struct LogSetting {
  ActuatorKind kind{};
  Bench bench;
  std::vector<std::string> undone;              ///< causes that are gone
  std::map<std::string, double> added = {};     ///< to constants that were fitted, known only by what they gave: "mass"
  std::map<std::string, double> channels = {};  ///< factors of what a reference log shows: "external_torque" -> 2
  double strength = 1.0;                        ///< torque per effort, times what it was
  double gear = 1.0;                            ///< motor turns per joint turn, times what they were
  double warmer = 0.0;                          ///< [K] than a reference log shows
  double resistance = 0.0;                      ///< [Ohm] in series with a winding
};

struct LogChangeKind;

struct LogChange {
  const LogChangeKind* kind = nullptr;
  std::string cause;          ///< that is gone; empty: none
  std::vector<double> sizes;  ///< in SI units, as the kind reads them
  std::vector<double> sds;    ///< shape (sizes): how well they are known
};

struct LogChangeKind {
  const char* name;  ///< "mass"
  /// \throws ConfigError: an unknown cause, an implausible number.
  LogChange (*read)(const YamlNode& node);
  /// \throws ConfigError: this bench cannot be changed so.
  void (*apply)(const LogChange& change, LogSetting& setting);
  bool shown_by_log = false;  ///< the log that is recorded afterwards shows it by itself: nothing has to be added there
};

namespace log_changes {
std::span<const LogChangeKind* const> all();
}

/// All that was done at once.
struct LogChanges : ChangeList<LogChange> {
  /// \throws ConfigError as the kinds, and all that YamlNode refuses.
  static LogChanges read(const YamlNode& root);
  /// \param recorded  true: for a log from afterwards; false: for a reference log that shows the bench as it was
  void apply(LogSetting& setting, bool recorded) const;
};

/// A size with its standard deviation: keys NAME_UNIT and NAME_sd_UNIT.
void readSize(const YamlNode& node, const std::string& name, const std::string& unit, const Range& range,
              LogChange& change);
/// A change of one factor in [0.01, 100]: keys factor and factor_sd.
LogChange readFactor(const YamlNode& node);

}  // namespace simgap
