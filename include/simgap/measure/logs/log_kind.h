/// \file
/// What a kind of log is to everything that does not know its equation. One file of src/measure/logs/kinds per kind,
/// found by CMake.
#pragma once

#include <span>
#include <string_view>

#include "simgap/measure/logs/bench.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap {

/// How the channels came about decides what a fault looks like in them.
enum class FaultChecks {
  kMotion,      ///< channels that move on: limits, stuck and lost samples, wrong signs
  kLevels,      ///< set to levels, limits included: of the answer only lost samples can be told
  kDeflection,  ///< a force over a deflection, either of which may sit at its sensor's limit
};

struct LogKind {
  ActuatorKind kind;
  const char* name;  ///< of its models: "gearbox"
  /// \throws DataError as the reader of the kind, and where a channel is missing. nullptr: made of another log's rows.
  PreparedLog (*prepare)(const CsvTable& table, const Bench& bench, const FrictionDataOptions& options);
  FaultChecks checks;
  const char* answer = "";                                        ///< column of what answers to the levels
  Eigen::ArrayXd ActuatorRows::*answers = &ActuatorRows::effort;  ///< its rows
  bool is_drive = false;         ///< effort against load, dry and viscous friction: presliding is in all of them
  bool at_joint = false;         ///< a drive that may know its joint's angle, and that can be played freely
  bool fits_in_turn = false;     ///< a cause bends what the one before it left: they are fitted one after another
  const char* law = nullptr;     ///< friction law of a model that bears the kind's name
  const char* effect = nullptr;  ///< that every model of this kind has
};

const LogKind& kindOf(ActuatorKind kind);

namespace log_kinds {
std::span<const LogKind* const> all();
/// By the name of its models; nullptr: none is called so.
const LogKind* find(std::string_view name);
}  // namespace log_kinds

}  // namespace simgap
