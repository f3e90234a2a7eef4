#include "simgap/core/yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "simgap/core/rotation.h"
#include "simgap/core/run_directory.h"
#include "simgap/core/text.h"
#include "yaml_tree.h"

namespace simgap {

struct YamlNode::Quantity {
  YamlNode node;
  UnitConversion conversion;
};

YamlNode::YamlNode(std::shared_ptr<const std::string> file, std::shared_ptr<YamlValue> root,
                   std::shared_ptr<YamlValue> value, std::string path)
    : file_(std::move(file)), root_(std::move(root)), value_(std::move(value)), path_(std::move(path)) {}

YamlNode YamlNode::load(const std::filesystem::path& file) { return parse(readFile(file), file.string()); }

YamlNode YamlNode::parse(const std::string& text, const std::string& name) {
  const auto file = std::make_shared<const std::string>(name);
  const std::shared_ptr<YamlValue> root = parseYamlTree(text, name);
  return YamlNode(file, root, root, "");
}

bool YamlNode::isMap() const { return value_->kind == YamlValue::Kind::kMap; }
bool YamlNode::isSequence() const { return value_->kind == YamlValue::Kind::kSequence; }
bool YamlNode::isScalar() const { return value_->kind == YamlValue::Kind::kScalar; }

bool YamlNode::has(std::string_view key) const { return value_->indexOf(key).has_value(); }

YamlNode YamlNode::at(std::string_view key) const {
  if (const auto node = find(key)) return *node;
  failMissing(fmt::format("the key '{}'", key));
}

std::optional<YamlNode> YamlNode::find(std::string_view key) const {
  expectMap();
  value_->remember({std::string(key), ""});
  const auto entry = value_->indexOf(key);
  return entry ? std::optional(child(*entry)) : std::nullopt;
}

std::vector<YamlNode> YamlNode::items() const {
  if (!isSequence()) fail(fmt::format("found {}, expected a sequence", value_->description()));
  std::vector<YamlNode> nodes;
  for (std::size_t i = 0; i < value_->items.size(); ++i) {
    nodes.push_back(YamlNode(file_, root_, value_->items[i], yamlItemPath(path_, i)));
  }
  return nodes;
}

std::vector<std::string> YamlNode::keys() const {
  expectMap();
  return value_->keys;
}

std::string YamlNode::text() const {
  if (!isScalar()) fail(fmt::format("found {}, expected a text", value_->description()));
  return value_->scalar;
}

bool YamlNode::boolean() const {
  const bool plain = isScalar() && value_->plain;
  if (plain && value_->scalar == "true") return true;
  if (plain && value_->scalar == "false") return false;
  fail(fmt::format("found {}, expected true or false", value_->description()));
}

double YamlNode::number(const Range& range) const { return convertedNumber({}, "", range); }

long YamlNode::integer(long lower, long upper) const {
  std::string_view digits = value_->scalar;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  long value = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (isScalar() && value_->plain && error == std::errc() && stop == end && value >= lower && value <= upper) {
    return value;
  }
  const std::string range = upper == std::numeric_limits<long>::max() ? fmt::format(">= {}", lower)
                                                                      : fmt::format("from {} to {}", lower, upper);
  fail(fmt::format("found {}, expected an integer {}", value_->description(), range));
}

std::uint64_t YamlNode::seed() const {
  std::uint64_t value = 0;
  const std::string& digits = value_->scalar;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (isScalar() && value_->plain && error == std::errc() && stop == end) return value;
  fail(fmt::format("found {}, expected an integer from 0 to {}", value_->description(),
                   std::numeric_limits<std::uint64_t>::max()));
}

std::string YamlNode::oneOf(const std::vector<std::string>& choices) const {
  if (isScalar() && std::ranges::find(choices, value_->scalar) != choices.end()) return value_->scalar;
  fail(fmt::format("found {}, expected {}{}", value_->description(), choices.size() == 1 ? "" : "one of ",
                   fmt::join(choices, ", ")));
}

Eigen::Vector3d YamlNode::vector3() const {
  const std::string expected = "expected a sequence of three numbers";
  if (!isSequence()) fail(fmt::format("found {}, {}", value_->description(), expected));
  const std::vector<YamlNode> elements = items();
  if (elements.size() != 3) fail(fmt::format("found a sequence of {}, {}", elements.size(), expected));
  return {elements[0].number(), elements[1].number(), elements[2].number()};
}

bool YamlNode::hasQuantity(std::string_view stem, std::string_view unit) const {
  return !matchQuantity(value_->keys, stem, unit).empty();
}

double YamlNode::quantity(std::string_view stem, std::string_view unit, const Range& range) const {
  const Quantity found = quantityNode(stem, unit);
  return found.node.convertedNumber(found.conversion, unit, range);
}

std::optional<double> YamlNode::findQuantity(std::string_view stem, std::string_view unit, const Range& range) const {
  const auto found = findQuantityNode(stem, unit);
  if (!found) return std::nullopt;
  return found->node.convertedNumber(found->conversion, unit, range);
}

Eigen::Quaterniond YamlNode::unitQuaternion() const {
  const std::vector<YamlNode> cells = items();
  if (cells.size() != 4) fail(fmt::format("found {} numbers, expected a quaternion [w, x, y, z]", cells.size()));
  const Eigen::Quaterniond q(cells[0].number(), cells[1].number(), cells[2].number(), cells[3].number());
  if (std::abs(q.norm() - 1.0) > kUnitLengthTolerance) {
    fail(fmt::format("found a quaternion of length {:.6g}, expected 1 within {:g}", q.norm(), kUnitLengthTolerance));
  }
  return q;
}

Eigen::Vector3d YamlNode::vectorQuantity(std::string_view stem, std::string_view unit) const {
  const Quantity found = quantityNode(stem, unit);
  const Eigen::Vector3d vector = found.node.vector3().unaryExpr(found.conversion);
  if (vector.cwiseAbs().maxCoeff() > largestPlausible(unit)) {
    found.node.fail(fmt::format("found {:g} {}, expected at most {:g}", vector.cwiseAbs().maxCoeff(), unit,
                                largestPlausible(unit)));
  }
  return vector;
}

void YamlNode::expectAllRead() const {
  std::set<const YamlValue*> seen;
  YamlNode(file_, root_, root_, "").expectRead(seen);
}

void YamlNode::fail(const std::string& sentence) const { failInYaml(*file_, value_->line, path_, sentence); }

YamlNode YamlNode::child(std::size_t entry) const {
  value_->read[entry] = true;
  return YamlNode(file_, root_, value_->values[entry], yamlChildPath(path_, value_->keys[entry]));
}

std::optional<YamlNode::Quantity> YamlNode::findQuantityNode(std::string_view stem, std::string_view unit) const {
  expectMap();
  value_->remember({std::string(stem), std::string(unit)});
  const std::vector<QuantityMatch> matches = matchQuantity(value_->keys, stem, unit);
  if (matches.empty()) return std::nullopt;
  if (matches.size() > 1) {
    failAtEntry(matches[1].index,
                fmt::format("found '{}' beside it, expected only one of them", value_->keys[matches[0].index]));
  }
  return Quantity{child(matches[0].index), matches[0].conversion};
}

YamlNode::Quantity YamlNode::quantityNode(std::string_view stem, std::string_view unit) const {
  if (const auto found = findQuantityNode(stem, unit)) return *found;
  std::vector<std::string> names;
  std::vector<std::size_t> entries;
  for (std::size_t i = 0; i < value_->keys.size(); ++i) {
    if (value_->read[i]) continue;
    names.push_back(value_->keys[i]);
    entries.push_back(i);
  }
  if (const auto mistake = findUnitMistake(names, stem, unit)) failAtEntry(entries[mistake->index], mistake->sentence);
  failMissing(
      fmt::format("one of the keys {}", fmt::join(YamlKnown{std::string(stem), std::string(unit)}.spellings(), ", ")));
}

double YamlNode::convertedNumber(const UnitConversion& conversion, std::string_view unit, const Range& range) const {
  const auto number = isScalar() && value_->plain ? parseNumber(value_->scalar) : std::nullopt;
  if (!number) fail(fmt::format("found {}, expected {}", value_->description(), range.expected));
  const double value = conversion(*number);
  const bool inside = std::isfinite(value) && value <= range.upper && value >= range.lower &&
                      !(range.lower_open && value == range.lower);
  if (inside && std::abs(value) > largestPlausible(unit)) {
    fail(fmt::format("found {:g} {}, expected a size of at most {:g}", value, unit, largestPlausible(unit)));
  }
  if (inside) return value;
  const std::string in_asked_unit = conversion.isIdentity() ? "" : fmt::format(" ({:.6g} {})", value, unit);
  fail(fmt::format("found {}{}, expected {}", abridged(value_->scalar), in_asked_unit, range.expected));
}

std::string yamlText(std::string_view text) {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
  constexpr std::string_view kOther = "0123456789-./";
  const auto plain = [&](char c) { return kLetters.find(c) != kLetters.npos || kOther.find(c) != kOther.npos; };
  const bool word = text == "null" || text == "Null" || text == "NULL";
  if (!text.empty() && kLetters.find(text[0]) != kLetters.npos && std::ranges::all_of(text, plain) && !word) {
    return std::string(text);
  }
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted.append(1, '\\').append(1, c);
    } else if (static_cast<unsigned char>(c) < 0x20) {
      quoted += fmt::format("\\x{:02x}", c);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

void YamlNode::expectMap() const {
  if (!isMap()) fail(fmt::format("found {}, expected a map", value_->description()));
}

void YamlNode::expectRead(std::set<const YamlValue*>& seen) const {
  // Aliases can make far more paths than there are values.
  if (!seen.insert(value_.get()).second) return;
  for (std::size_t i = 0; i < value_->items.size(); ++i) {
    YamlNode(file_, root_, value_->items[i], yamlItemPath(path_, i)).expectRead(seen);
  }
  for (std::size_t i = 0; i < value_->keys.size(); ++i) {
    if (!value_->read[i]) failUnknown(i);
    child(i).expectRead(seen);
  }
}

void YamlNode::failAtEntry(std::size_t entry, const std::string& sentence) const {
  failInYaml(*file_, value_->key_lines[entry], yamlChildPath(path_, value_->keys[entry]), sentence);
}

void YamlNode::failMissing(const std::string& expected) const {
  const std::string found = value_->keys.empty() ? "no keys" : fmt::format("only {}", fmt::join(value_->keys, ", "));
  fail(fmt::format("found {}, expected {}", found, expected));
}

void YamlNode::failUnknown(std::size_t entry) const {
  const std::string& key = value_->keys[entry];
  std::vector<std::string> missing;
  std::vector<std::string> known;
  for (const YamlKnown& asked : value_->known) {
    const std::string name = quantityName(asked.stem, asked.unit);
    if (std::ranges::find(known, name) == known.end()) known.push_back(name);
    if (value_->holds(asked)) continue;
    const auto mistake = findUnitMistake({&key, 1}, asked.stem, asked.unit);
    if (mistake) failAtEntry(entry, mistake->sentence);
    std::ranges::copy(asked.spellings(), std::back_inserter(missing));
  }
  const std::string nearest = nearestName(key, missing);
  if (!nearest.empty()) failAtEntry(entry, fmt::format("found an unknown key, expected '{}'", nearest));
  const std::string all = known.empty() ? "none here" : fmt::format("one of {}", fmt::join(known, ", "));
  failAtEntry(entry, fmt::format("found an unknown key, expected {}", all));
}

}  // namespace simgap
