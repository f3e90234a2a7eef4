/// \file
/// The tree of a YAML document, with the line of everything and a record of what was asked of it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace simgap {

/// A key or a quantity somebody asked for.
struct YamlKnown {
  std::string stem;
  std::string unit;  ///< empty: a plain key
  bool operator==(const YamlKnown&) const = default;
  /// Every key that would have been taken.
  std::vector<std::string> spellings() const;
};

/// An aliased value is shared by all its users: reading it through one of them counts for all, since it stands in the
/// file only once.
struct YamlValue {
  enum class Kind { kNull, kScalar, kSequence, kMap };
  Kind kind = Kind::kNull;
  int line = 1;

  std::string scalar;
  bool plain = false;  ///< neither quoted nor tagged: may be a number

  std::vector<std::shared_ptr<YamlValue>> items;

  std::vector<std::string> keys;  ///< of a map; the next three have its shape
  std::vector<int> key_lines;
  std::vector<std::shared_ptr<YamlValue>> values;
  std::vector<bool> read;
  std::vector<YamlKnown> known;  ///< what was asked of this map, found or not

  void remember(YamlKnown asked);
  std::optional<std::size_t> indexOf(std::string_view key) const;
  bool holds(const YamlKnown& asked) const;
  std::string description() const;  ///< what stands here, for "found ..."
};

/// \throws ConfigError: no YAML, duplicate keys, several documents.
std::shared_ptr<YamlValue> parseYamlTree(const std::string& text, const std::string& file);

/// "FILE:LINE: PATH: sentence"; the root has no path.
[[noreturn]] void failInYaml(const std::string& file, int line, const std::string& path, const std::string& sentence);

std::string yamlChildPath(const std::string& path, std::string_view key);
std::string yamlItemPath(const std::string& path, std::size_t index);

}  // namespace simgap
