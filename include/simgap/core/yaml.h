/// \file
/// Strict reading of YAML: a missing key, an unknown key, a wrong type, a wrong unit or a value outside its range is a
/// ConfigError that names the file, the line and the path.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/units.h"

namespace simgap {

struct YamlValue;

/// The values a number may take.
struct Range {
  double lower;
  double upper;
  bool lower_open = false;    ///< lower itself is excluded
  std::string_view expected;  ///< in words, for the error: "> 0"
};
inline constexpr Range kAnyNumber{-kInfinity, kInfinity, false, "a finite number"};
inline constexpr Range kPositive{0.0, kInfinity, true, "a number > 0"};
inline constexpr Range kNonNegative{0.0, kInfinity, false, "a number >= 0"};
inline constexpr Range kEfficiency{0.0, 1.0, true, "a number in (0, 1]"};

/// A node of a YAML document that remembers what was read, so that what was not read can be refused.
/// Cheap to copy; every node keeps the document alive.
class YamlNode {
 public:
  /// \throws ConfigError when the file cannot be read or is not YAML.
  static YamlNode load(const std::filesystem::path& file);
  /// The same from text; `name` stands for the file in errors.
  static YamlNode parse(const std::string& text, const std::string& name);

  bool isMap() const;
  bool isSequence() const;
  bool isScalar() const;
  /// Path from the root: "muscles[2].shock_cord".
  const std::string& path() const { return path_; }

  /// \name Children. Asking for a key counts as reading it.
  ///@{
  bool has(std::string_view key) const;                      ///< an exact key; does not count as reading
  YamlNode at(std::string_view key) const;                   ///< \throws ConfigError when missing
  std::optional<YamlNode> find(std::string_view key) const;  ///< empty when missing
  std::vector<YamlNode> items() const;                       ///< of a sequence; \throws ConfigError when it is none
  std::vector<std::string> keys() const;                     ///< of a map, in file order; does not count as reading
  ///@}

  /// \name Scalars.
  ///@{
  std::string text() const;
  bool boolean() const;
  double number(const Range& range = kAnyNumber) const;  ///< finite, inside the range
  long integer(long lower, long upper) const;
  std::uint64_t seed() const;  ///< any unsigned 64-bit integer
  /// One of `choices`; the error lists them.
  std::string oneOf(const std::vector<std::string>& choices) const;
  Eigen::Vector3d vector3() const;  ///< a sequence of three finite numbers
  ///@}

  /// \name Quantities: the key is `stem` + "_" + a unit that converts to the SI unit `unit`.
  /// `quantity("radius", "m")` reads radius_m: 0.006 and radius_mm: 6 alike. The range applies to the SI value.
  ///@{
  bool hasQuantity(std::string_view stem, std::string_view unit) const;
  double quantity(std::string_view stem, std::string_view unit, const Range& range = kAnyNumber) const;
  std::optional<double> findQuantity(std::string_view stem, std::string_view unit,
                                     const Range& range = kAnyNumber) const;
  Eigen::Vector3d vectorQuantity(std::string_view stem, std::string_view unit) const;
  /// [w, x, y, z], as it stands there. \throws ConfigError: of another length than 1 (kUnitLengthTolerance).
  Eigen::Quaterniond unitQuaternion() const;
  ///@}

  /// Refuses every key of the document nobody asked for, with the nearest known key as a suggestion. A value that
  /// several aliases share counts as read when one of them was.
  /// Call it on any node, once, after reading.
  void expectAllRead() const;

  /// A ConfigError "FILE:LINE: PATH: sentence" about this node.
  [[noreturn]] void fail(const std::string& sentence) const;

 private:
  struct Quantity;
  YamlNode(std::shared_ptr<const std::string> file, std::shared_ptr<YamlValue> root, std::shared_ptr<YamlValue> value,
           std::string path);
  YamlNode child(std::size_t entry) const;
  std::optional<Quantity> findQuantityNode(std::string_view stem, std::string_view unit) const;
  Quantity quantityNode(std::string_view stem, std::string_view unit) const;
  double convertedNumber(const UnitConversion& conversion, std::string_view unit, const Range& range) const;
  void expectMap() const;
  void expectRead(std::set<const YamlValue*>& seen) const;
  [[noreturn]] void failAtEntry(std::size_t entry, const std::string& sentence) const;
  [[noreturn]] void failMissing(const std::string& expected) const;
  [[noreturn]] void failUnknown(std::size_t entry) const;

  std::shared_ptr<const std::string> file_;
  std::shared_ptr<YamlValue> root_;
  std::shared_ptr<YamlValue> value_;
  std::string path_;
};

/// A text as it stands in a YAML file: as it is when it can be nothing but a text, otherwise in double quotes.
std::string yamlText(std::string_view text);

}  // namespace simgap
