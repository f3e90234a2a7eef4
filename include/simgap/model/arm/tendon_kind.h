/// \file
/// What pulls besides a motor that winds a line on its spindle: ligaments and springs, pneumatic muscles under a
/// pressure, motors at joints. One file of src/model/arm/tendons per kind, found by CMake; reading,
/// writing, fitting and both simulations know a kind by this table alone.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "simgap/core/yaml.h"

namespace simgap {

inline constexpr int kMaxTendonParameters = 8;
using TendonParameters = std::array<double, kMaxTendonParameters>;  ///< in the kind's order; the rest unused

struct TendonParameter {
  std::string_view name;  ///< in the file, without its unit: "rest_length"
  std::string_view unit;
  std::string_view key;  ///< with it: "rest_length_m"
  Range range;
  std::optional<double> otherwise = {};  ///< where the file does not say
};

/// What a kind is told to do, one number per pose or row of a motion: a column `<quantity>_<line>_<unit>` of pose sets.
struct TendonCommand {
  std::string_view quantity;  ///< "pressure"; empty: the kind takes no command
  std::string_view unit;      ///< "Pa"
  double typical = 0.0;       ///< of that size commands are, where some have to be made up
  double lowest = -std::numeric_limits<double>::infinity();
  int lag = -1;  ///< parameter: time constant [s] by which what acts follows the command in motions; -1: at once
  explicit operator bool() const { return !quantity.empty(); }
};

/// Of a line of length L at rest.
struct TendonPull {
  double energy = 0.0;              ///< V(L) [J]
  double force = 0.0;               ///< dV/dL [N], > 0 pulls its ends together
  double stiffness = 0.0;           ///< dF/dL [N/m]
  TendonParameters by_parameter{};  ///< of the force
  double by_command = 0.0;          ///< of the force
};

struct TendonKind {
  std::string_view name;  ///< in files
  std::string_view what;  ///< one sentence a person understands
  std::string_view equation;
  std::span<const TendonParameter> parameters;
  TendonPull (*pull)(const TendonParameters& p, double length, double command);
  /// Force while the length changes at `rate` [N].
  double (*force)(const TendonParameters& p, double length, double rate, double command);
  TendonCommand command = {};
  /// Acts about a joint instead of along a line: its length is the joint's angle [rad], its force a torque [N m].
  bool at_joint = false;
};

namespace tendon_kinds {
std::span<const TendonKind* const> all();
}

}  // namespace simgap
