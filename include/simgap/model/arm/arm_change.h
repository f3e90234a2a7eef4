/// \file
/// What was done to an arm between two recordings, in physical words: `simgap/change/1` (docs/formats.md). One file of
/// src/model/arm/changes per kind, found by CMake.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/model/arm/arm.h"
#include "simgap/model/change_list.h"

namespace simgap {

struct ArmChangeKind;

struct ArmChange {
  const ArmChangeKind* kind = nullptr;
  int target = 0;                                   ///< index of the body or muscle
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< [m] in the body's frame
  std::string cause;                                ///< that is gone: "payload:forearm"; empty: none
  std::vector<double> sizes;                        ///< in SI units, as the kind reads them
  std::vector<double> sds;                          ///< shape (sizes): how well they are known
};

struct ArmChangeKind {
  const char* name;  ///< "mass"
  /// \throws ConfigError: a body or muscle that the model does not have, an implausible number.
  ArmChange (*read)(const YamlNode& node, const ArmModel& model);
  /// \throws ConfigError: the model cannot be changed so.
  void (*apply)(const ArmChange& change, ArmModel& model);
};

namespace arm_changes {
std::span<const ArmChangeKind* const> all();
}

/// All that was done at once.
struct ArmChanges : ChangeList<ArmChange> {
  /// \throws ConfigError as the kinds, and all that YamlNode refuses.
  static ArmChanges read(const YamlNode& root, const ArmModel& model);
  void apply(ArmModel& model) const;
  bool undoes(const std::string& cause) const;  ///< "payload:forearm"
};

/// Index of what a node names. \throws ConfigError: none of that name.
int bodyOf(const YamlNode& node, const ArmModel& model);
int muscleOf(const YamlNode& node, const ArmModel& model);

}  // namespace simgap
