/// \file
/// What a line without a motor pulls with. One file of src/model/arm/tendons per kind, found by CMake; reading,
/// writing, fitting and both simulations know a kind by this table alone.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "simgap/core/yaml.h"

namespace simgap {

inline constexpr int kMaxTendonParameters = 4;
using TendonParameters = std::array<double, kMaxTendonParameters>;  ///< in the kind's order; the rest unused

struct TendonParameter {
  std::string_view name;  ///< in the file, without its unit: "rest_length"
  std::string_view unit;
  std::string_view key;  ///< with it: "rest_length_m"
  Range range;
};

/// Of a line of length L at rest.
struct TendonPull {
  double energy = 0.0;              ///< V(L) [J]
  double force = 0.0;               ///< dV/dL [N], > 0 pulls its ends together
  double stiffness = 0.0;           ///< dF/dL [N/m]
  TendonParameters by_parameter{};  ///< of the force
};

struct TendonKind {
  std::string_view name;  ///< in files
  std::string_view what;  ///< one sentence a person understands
  std::string_view equation;
  std::span<const TendonParameter> parameters;
  TendonPull (*pull)(const TendonParameters& p, double length);
  /// Force while the length changes at `rate` [N].
  double (*force)(const TendonParameters& p, double length, double rate);
};

namespace tendon_kinds {
std::span<const TendonKind* const> all();
}

}  // namespace simgap
