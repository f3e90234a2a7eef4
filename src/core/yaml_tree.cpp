#include "yaml_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <unordered_map>

#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

// Far more than any file of simgap holds; more would only be slow, or too deep for the parser's stack.
constexpr std::size_t kLargestYaml = std::size_t{16} << 20U;
constexpr std::size_t kDeepest = 64;

/// Builds the tree from the parser's events: yaml-cpp's own nodes forget whether a scalar was quoted, and keep
/// duplicate keys silently.
class Builder : public YAML::EventHandler {
 public:
  explicit Builder(const std::string& file) : file_(file) {}
  const std::shared_ptr<YamlValue>& root() const { return root_; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ > 0) failInYaml(file_, lineOf(mark), "", "found a second document, expected one");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(make(YamlValue::Kind::kNull, mark, anchor));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const std::shared_ptr<YamlValue> value = anchors_.at(anchor);
    const auto is_value = [&](const Frame& frame) { return frame.value == value; };
    if (std::ranges::any_of(open_, is_value)) {
      failInYaml(file_, lineOf(mark), nextPath(), "found an alias of a value that holds it, expected no such loop");
    }
    add(value);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    const std::shared_ptr<YamlValue> value = make(YamlValue::Kind::kScalar, mark, anchor);
    value->scalar = text;
    value->plain = tag == "?";
    if (!open_.empty() && open_.back().value->kind == YamlValue::Kind::kMap && !open_.back().has_key) {
      addKey(text, lineOf(mark));
    } else {
      add(value);
    }
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(make(YamlValue::Kind::kSequence, mark, anchor));
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(make(YamlValue::Kind::kMap, mark, anchor));
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  struct Frame {
    std::shared_ptr<YamlValue> value;
    std::string path;
    bool has_key = false;                                 ///< of a map: its value comes next
    std::unordered_map<std::string, int> key_lines = {};  ///< a search through a map's keys would be quadratic
  };

  static int lineOf(const YAML::Mark& mark) { return mark.line + 1; }

  std::shared_ptr<YamlValue> make(YamlValue::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    auto value = std::make_shared<YamlValue>();
    value->kind = kind;
    value->line = lineOf(mark);
    if (anchor != YAML::NullAnchor) anchors_[anchor] = value;
    return value;
  }

  /// Path of the value that is read next.
  std::string nextPath() const {
    if (open_.empty()) return "";
    const Frame& frame = open_.back();
    if (frame.value->kind == YamlValue::Kind::kSequence) return yamlItemPath(frame.path, frame.value->items.size());
    return frame.has_key ? yamlChildPath(frame.path, frame.value->keys.back()) : frame.path;
  }

  void addKey(const std::string& key, int line) {
    YamlValue& map = *open_.back().value;
    const auto [first, is_new] = open_.back().key_lines.emplace(key, line);
    if (!is_new) {
      failInYaml(file_, line, yamlChildPath(open_.back().path, key),
                 fmt::format("found the key twice, first on line {}, expected it once", first->second));
    }
    map.keys.push_back(key);
    map.key_lines.push_back(line);
    open_.back().has_key = true;
  }

  void add(const std::shared_ptr<YamlValue>& value) {
    if (open_.empty()) {
      root_ = value;
      return;
    }
    Frame& frame = open_.back();
    if (frame.value->kind == YamlValue::Kind::kSequence) {
      frame.value->items.push_back(value);
      return;
    }
    if (!frame.has_key) {
      failInYaml(file_, value->line, frame.path,
                 fmt::format("found {} as a key, expected a name", value->description()));
    }
    // The parser places a missing value where it noticed, often on the next line.
    if (value->kind == YamlValue::Kind::kNull) value->line = frame.value->key_lines.back();
    frame.value->values.push_back(value);
    frame.value->read.push_back(false);
    frame.has_key = false;
  }

  void open(const std::shared_ptr<YamlValue>& value) {
    std::string path = nextPath();
    if (open_.size() >= kDeepest) {
      failInYaml(file_, value->line, "", fmt::format("found values nested more than {} deep, expected less", kDeepest));
    }
    add(value);
    open_.push_back({value, std::move(path)});
  }

  const std::string& file_;
  int documents_ = 0;
  std::shared_ptr<YamlValue> root_ = std::make_shared<YamlValue>();
  std::map<YAML::anchor_t, std::shared_ptr<YamlValue>> anchors_;
  std::vector<Frame> open_;
};

}  // namespace

std::vector<std::string> YamlKnown::spellings() const {
  if (unit.empty()) return {stem};
  std::vector<std::string> names;
  for (const std::string& suffix : unitsLike(unit)) names.push_back(quantityName(stem, suffix));
  return names;
}

void YamlValue::remember(YamlKnown asked) {
  if (std::ranges::find(known, asked) == known.end()) known.push_back(std::move(asked));
}

std::optional<std::size_t> YamlValue::indexOf(std::string_view key) const {
  const auto found = std::ranges::find(keys, key);
  if (found == keys.end()) return std::nullopt;
  return static_cast<std::size_t>(found - keys.begin());
}

bool YamlValue::holds(const YamlKnown& asked) const {
  return std::ranges::any_of(asked.spellings(), [&](const std::string& name) { return indexOf(name).has_value(); });
}

std::string YamlValue::description() const {
  switch (kind) {
    case Kind::kNull:
      return "nothing";
    case Kind::kSequence:
      return "a sequence";
    case Kind::kMap:
      return "a map";
    case Kind::kScalar:
      break;
  }
  if (!plain) return fmt::format("the text '{}'", abridged(scalar));
  return parseNumber(scalar) ? abridged(scalar) : fmt::format("'{}'", abridged(scalar));
}

std::shared_ptr<YamlValue> parseYamlTree(const std::string& text, const std::string& file) {
  if (text.size() > kLargestYaml) {
    throw ConfigError(
        fmt::format("{}: found {} MiB, expected at most {}", file, text.size() >> 20U, kLargestYaml >> 20U));
  }
  Builder builder(file);
  // yaml-cpp 0.7 notices a quote that is never closed only when the text does not end in an empty line.
  std::istringstream stream(text.substr(0, text.find_last_not_of(" \t\r\n") + 1));
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    failInYaml(file, error.mark.line + 1, "", fmt::format("found no valid YAML: {}", error.msg));
  }
  return builder.root();
}

void failInYaml(const std::string& file, int line, const std::string& path, const std::string& sentence) {
  const std::string place = path.empty() ? "" : path + ": ";
  throw ConfigError(fmt::format("{}:{}: {}{}", file, line, place, sentence));
}

std::string yamlChildPath(const std::string& path, std::string_view key) {
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

std::string yamlItemPath(const std::string& path, std::size_t index) { return fmt::format("{}[{}]", path, index); }

}  // namespace simgap
