/// \file
/// Unit suffixes of keys and columns (`_rad_s`, `_mm`, `_degC`). Inside the program everything is SI.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace simgap {

/// An affine conversion: SI value = factor * value + offset.
struct UnitConversion {
  double factor = 1.0;
  double offset = 0.0;
  double operator()(double value) const noexcept { return factor * value + offset; }
};

/// Conversion from the unit `suffix` ("deg_s") to `target` ("rad_s"), both without a leading underscore.
/// Empty when either is no unit or they measure different things.
std::optional<UnitConversion> unitConversion(std::string_view suffix, std::string_view target);

/// True when `suffix` is a unit of the table.
bool isUnit(std::string_view suffix);

/// The suffixes that convert to `target`, in the order of the table: for error messages.
std::vector<std::string> unitsLike(std::string_view target);

/// A name split into its stem and its unit: "shaft_biceps_deg" -> {"shaft_biceps", "deg"}; the longest unit wins.
/// Empty unit when there is none.
struct UnitName {
  std::string stem;
  std::string unit;
};
UnitName splitUnit(std::string_view name);

}  // namespace simgap
