/// \file
/// What was done to an arm or to a bench between two recordings, `simgap/change/1` (docs/formats.md): what both have.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "simgap/core/yaml.h"

namespace simgap {

/// All that was done at once. \tparam Change  with kind, cause (empty: none), sizes and sds (shape (sizes))
template <class Change>
struct ChangeList {
  std::string name;
  std::vector<Change> changes;
};

/// \param kinds  with name and read(node, model...). \throws ConfigError as the kinds, and all that YamlNode refuses.
template <class Changes, class Kinds, class... Model>
Changes readChanges(const YamlNode& root, const Kinds& kinds, const Model&... model) {
  const YamlNode format = root.at("format");
  if (format.text() != "simgap/change/1") {
    format.fail(fmt::format("found {}, expected simgap/change/1", format.text()));
  }
  std::vector<std::string> names;
  for (const auto* kind : kinds) names.emplace_back(kind->name);
  Changes all;
  if (const auto name = root.find("name")) all.name = name->text();
  const YamlNode list = root.at("changes");
  for (const YamlNode& node : list.items()) {
    const std::string name = node.at("kind").oneOf(names);
    const auto* kind = *std::ranges::find_if(kinds, [&](const auto* k) { return k->name == name; });
    all.changes.push_back(kind->read(node, model...));
    all.changes.back().kind = kind;
  }
  if (all.changes.empty()) list.fail("found no change, expected at least one");
  root.expectAllRead();
  return all;
}

/// The same with one uncertain number moved by a standard deviation, forward (+1) and back (-1), a pair for each.
template <class Changes>
std::vector<std::pair<Changes, Changes>> withinUncertainty(const Changes& all) {
  std::vector<std::pair<Changes, Changes>> pairs;
  for (std::size_t c = 0; c < all.changes.size(); ++c) {
    for (std::size_t i = 0; i < all.changes[c].sizes.size(); ++i) {
      const double sd = all.changes[c].sds[i];
      if (sd <= 0.0) continue;
      auto& [forward, back] = pairs.emplace_back(all, all);
      forward.changes[c].sizes[i] += sd;
      back.changes[c].sizes[i] -= sd;
    }
  }
  return pairs;
}

}  // namespace simgap
