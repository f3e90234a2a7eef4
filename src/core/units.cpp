#include "simgap/core/units.h"

#include <fast_float/fast_float.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

enum class Dimension {
  kAngle,
  kAngularVelocity,
  kAngularAcceleration,
  kCurrent,
  kVoltage,
  kForce,
  kTorque,
  kLength,
  kVelocity,
  kAcceleration,
  kTime,
  kPressure,
  kTemperature,
  kMass,
  kStiffness,
  kRotationalStiffness,
  kDamping,
  kRotationalDamping,
  kInertia,
  kArea,
  kDensity,
  kBackEmf,
  kTorqueConstant,
  kResistance,
  kInductance,
  kPower,
  kFrequency,
  kForcePerVoltage,
};

/// Value in the first unit of the dimension = factor * value + offset.
struct Unit {
  std::string_view suffix;
  Dimension dimension;
  double factor;
  double offset = 0.0;
};

constexpr double kPi = 3.14159265358979323846;

// Several spellings of one unit are several rows; error messages list them in this order.
constexpr Unit kUnits[] = {
    {"rad", Dimension::kAngle, 1.0},
    {"deg", Dimension::kAngle, kPi / 180.0},
    {"rad_s", Dimension::kAngularVelocity, 1.0},
    {"deg_s", Dimension::kAngularVelocity, kPi / 180.0},
    {"rpm", Dimension::kAngularVelocity, kPi / 30.0},
    {"rad_s2", Dimension::kAngularAcceleration, 1.0},
    {"A", Dimension::kCurrent, 1.0},
    {"mA", Dimension::kCurrent, 1e-3},
    {"V", Dimension::kVoltage, 1.0},
    {"mV", Dimension::kVoltage, 1e-3},
    {"uV", Dimension::kVoltage, 1e-6},
    {"N", Dimension::kForce, 1.0},
    {"mN", Dimension::kForce, 1e-3},
    {"kN", Dimension::kForce, 1e3},
    {"Nm", Dimension::kTorque, 1.0},
    {"mNm", Dimension::kTorque, 1e-3},
    {"m", Dimension::kLength, 1.0},
    {"mm", Dimension::kLength, 1e-3},
    {"cm", Dimension::kLength, 1e-2},
    {"m_s", Dimension::kVelocity, 1.0},
    {"mm_s", Dimension::kVelocity, 1e-3},
    {"m_s2", Dimension::kAcceleration, 1.0},
    {"s", Dimension::kTime, 1.0},
    {"ms", Dimension::kTime, 1e-3},
    {"Pa", Dimension::kPressure, 1.0},
    {"kPa", Dimension::kPressure, 1e3},
    {"MPa", Dimension::kPressure, 1e6},
    {"bar", Dimension::kPressure, 1e5},
    {"degC", Dimension::kTemperature, 1.0},
    {"C", Dimension::kTemperature, 1.0},
    {"K", Dimension::kTemperature, 1.0, -273.15},
    {"kg", Dimension::kMass, 1.0},
    {"g", Dimension::kMass, 1e-3},
    {"N_m", Dimension::kStiffness, 1.0},
    {"N_mm", Dimension::kStiffness, 1e3},
    {"Nm_rad", Dimension::kRotationalStiffness, 1.0},
    {"Ns_m", Dimension::kDamping, 1.0},
    {"Nms", Dimension::kRotationalDamping, 1.0},
    {"Nms_rad", Dimension::kRotationalDamping, 1.0},
    {"kg_m2", Dimension::kInertia, 1.0},
    {"m2", Dimension::kArea, 1.0},
    {"kg_m3", Dimension::kDensity, 1.0},
    {"g_cm3", Dimension::kDensity, 1e3},
    {"Vs", Dimension::kBackEmf, 1.0},
    {"V_s_rad", Dimension::kBackEmf, 1.0},
    {"Vs_rad", Dimension::kBackEmf, 1.0},
    {"Nm_A", Dimension::kTorqueConstant, 1.0},
    {"ohm", Dimension::kResistance, 1.0},
    {"H", Dimension::kInductance, 1.0},
    {"mH", Dimension::kInductance, 1e-3},
    {"W", Dimension::kPower, 1.0},
    {"Hz", Dimension::kFrequency, 1.0},
    {"kHz", Dimension::kFrequency, 1e3},
    {"N_V", Dimension::kForcePerVoltage, 1.0},
};

const Unit* findUnit(std::string_view suffix) {
  const auto found = std::ranges::find(kUnits, suffix, &Unit::suffix);
  return found == std::end(kUnits) ? nullptr : found;
}

/// The largest plausible value, in the first unit of the dimension. Angles count turns of motors over days, times may
/// be seconds since 1970.
double largestOf(Dimension dimension) {
  switch (dimension) {
    case Dimension::kAngle:
      return 1e8;
    case Dimension::kTime:
      return 1e11;
    case Dimension::kCurrent:
    case Dimension::kVoltage:
    case Dimension::kTemperature:
    case Dimension::kLength:
    case Dimension::kArea:
    case Dimension::kVelocity:
      return 1e5;
    case Dimension::kAngularVelocity:
    case Dimension::kAcceleration:
    case Dimension::kMass:
    case Dimension::kDensity:
      return 1e6;
    case Dimension::kAngularAcceleration:
    case Dimension::kForce:
    case Dimension::kTorque:
    case Dimension::kInertia:
    case Dimension::kPower:
    case Dimension::kFrequency:
    case Dimension::kDamping:
    case Dimension::kRotationalDamping:
    case Dimension::kForcePerVoltage:
    case Dimension::kBackEmf:
    case Dimension::kTorqueConstant:
      return 1e9;
    case Dimension::kPressure:
    case Dimension::kStiffness:
    case Dimension::kRotationalStiffness:
    case Dimension::kResistance:
    case Dimension::kInductance:
      return 1e12;
  }
  return kInfinity;
}

/// Edit distance that counts two swapped neighbours as one slip (optimal string alignment).
std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before, last);
    std::swap(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, substituted});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

/// Words behind a channel's name that say which one it is, and no unit: "velocity_ref".
constexpr std::string_view kRoles[] = {"cmd",      "command",   "commanded", "ref",     "reference", "set",
                                       "setpoint", "target",    "goal",      "desired", "des",       "est",
                                       "estimate", "estimated", "filtered",  "raw",     "error",     "err",
                                       "limit",    "id",        "index",     "flag",    "stamp"};

/// The part of `name` after `stem` + "_"; empty when it does not begin so.
std::string_view suffixAfter(std::string_view name, std::string_view stem) {
  if (name.size() <= stem.size() + 1 || !name.starts_with(stem) || name[stem.size()] != '_') return {};
  return name.substr(stem.size() + 1);
}

}  // namespace

std::optional<UnitConversion> unitConversion(std::string_view suffix, std::string_view target) {
  const Unit* from = findUnit(suffix);
  const Unit* to = findUnit(target);
  if (from == nullptr || to == nullptr || from->dimension != to->dimension) return std::nullopt;
  return UnitConversion{from->factor / to->factor, (from->offset - to->offset) / to->factor};
}

double largestPlausible(std::string_view suffix) {
  const Unit* unit = findUnit(suffix);
  return unit == nullptr ? kInfinity : largestOf(unit->dimension) / unit->factor;
}

bool isUnit(std::string_view suffix) { return findUnit(suffix) != nullptr; }

std::vector<std::string> unitsLike(std::string_view target) {
  std::vector<std::string> suffixes;
  const Unit* unit = findUnit(target);
  if (unit == nullptr) return suffixes;
  for (const Unit& other : kUnits) {
    if (other.dimension == unit->dimension) suffixes.emplace_back(other.suffix);
  }
  return suffixes;
}

UnitName splitUnit(std::string_view name) {
  // The leftmost underscore whose tail is a unit gives the longest unit; a stem is never empty.
  for (std::size_t at = name.find('_', 1); at < name.size(); at = name.find('_', at + 1)) {
    const std::string_view tail = name.substr(at + 1);
    if (isUnit(tail)) return {std::string(name.substr(0, at)), std::string(tail)};
  }
  return {std::string(name), ""};
}

std::string quantityName(std::string_view stem, std::string_view unit) {
  return unit.empty() ? std::string(stem) : fmt::format("{}_{}", stem, unit);
}

std::vector<QuantityMatch> matchQuantity(std::span<const std::string> names, std::string_view stem,
                                         std::string_view unit) {
  std::vector<QuantityMatch> matches;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (unit.empty()) {
      if (names[i] == stem) matches.push_back({i, "", {}});
      continue;
    }
    const std::string_view suffix = suffixAfter(names[i], stem);
    if (const auto conversion = unitConversion(suffix, unit)) matches.push_back({i, std::string(suffix), *conversion});
  }
  return matches;
}

std::optional<UnitMistake> findUnitMistake(std::span<const std::string> names, std::string_view stem,
                                           std::string_view unit) {
  if (unit.empty()) return std::nullopt;
  const std::string expected = fmt::format("expected one of {}", fmt::join(unitsLike(unit), ", "));
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == stem) return UnitMistake{i, fmt::format("unit is missing, {}", expected)};
    const std::string_view suffix = suffixAfter(names[i], stem);
    if (isUnit(suffix)) return UnitMistake{i, fmt::format("unit '{}' is of another kind, {}", suffix, expected)};
    // "motor_current_A" is a quantity of its own, not a "motor" in an unknown unit.
    const bool one_word = !suffix.empty() && suffix.find('_') == std::string_view::npos &&
                          std::ranges::find(kRoles, suffix) == std::end(kRoles);
    if (one_word) return UnitMistake{i, fmt::format("unit '{}' does not exist, {}", suffix, expected)};
  }
  return std::nullopt;
}

std::string nearestName(std::string_view name, std::span<const std::string> names) {
  const std::string* nearest = nullptr;
  std::size_t least = 0;
  for (const std::string& candidate : names) {
    const std::size_t distance = editDistance(name, candidate);
    if (3 * distance > std::max(name.size(), candidate.size())) continue;
    if (nearest == nullptr || distance < least) {
      nearest = &candidate;
      least = distance;
    }
  }
  return nearest == nullptr ? "" : *nearest;
}

std::optional<double> parseNumber(std::string_view text) {
  // from_chars takes no plus sign; "+-5" must stay refused.
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  if (plus) text.remove_prefix(1);
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = fast_float::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace simgap
