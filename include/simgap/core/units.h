/// \file
/// Unit suffixes of keys and columns (`_rad_s`, `_mm`, `_degC`), and the search for a quantity among names that carry
/// them. Inside the program everything is SI; a temperature is in degC.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace simgap {

/// Where a file says nothing else [m/s^2].
inline constexpr double kEarthGravity = 9.81;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// An affine conversion: target value = factor * value + offset.
struct UnitConversion {
  double factor = 1.0;
  double offset = 0.0;
  double operator()(double value) const noexcept { return factor * value + offset; }
  bool isIdentity() const noexcept { return factor == 1.0 && offset == 0.0; }
};

/// Conversion from the unit `suffix` ("deg_s") to `target` ("rad_s"), both without a leading underscore.
/// Empty when either is no unit or they measure different things.
std::optional<UnitConversion> unitConversion(std::string_view suffix, std::string_view target);

/// The largest size that a value in the unit `suffix` has on any robot, rig or in its surroundings, generously: beyond
/// it the file is wrong, not the world. Infinity without a unit.
double largestPlausible(std::string_view suffix);

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

/// `stem` with its unit, as a file writes it; the stem alone when the unit is empty.
std::string quantityName(std::string_view stem, std::string_view unit);

/// A name that stands for an asked quantity.
struct QuantityMatch {
  std::size_t index;          ///< of the name
  std::string unit;           ///< the unit it carries
  UnitConversion conversion;  ///< to the asked unit
};
/// Every name that is `stem` + "_" + a unit that converts to `unit`; with an empty unit: the name `stem`.
std::vector<QuantityMatch> matchQuantity(std::span<const std::string> names, std::string_view stem,
                                         std::string_view unit);

/// A name that has the right stem but no unit that fits.
struct UnitMistake {
  std::size_t index;     ///< of the name
  std::string sentence;  ///< "unit 'furlong' does not exist, expected one of m, mm, cm"
};
std::optional<UnitMistake> findUnitMistake(std::span<const std::string> names, std::string_view stem,
                                           std::string_view unit);

/// The name nearest to `name` by edit distance; empty when none is near enough to be a slip of the pen.
std::string nearestName(std::string_view name, std::span<const std::string> names);

/// A number in plain decimal or scientific notation ("-0.5", "+5", "1e3"). Empty for anything else: hexadecimal,
/// surrounding blanks, NaN, and what is infinite in double precision.
std::optional<double> parseNumber(std::string_view text);

}  // namespace simgap
