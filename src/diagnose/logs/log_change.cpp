#include "simgap/diagnose/logs/log_change.h"

#include <fmt/format.h>

#include <algorithm>

namespace simgap {
namespace {

LogChange readChange(const YamlNode& node) {
  std::vector<std::string> names;
  for (const LogChangeKind* kind : log_changes::all()) names.emplace_back(kind->name);
  const std::string name = node.at("kind").oneOf(names);
  const LogChangeKind& kind = **std::ranges::find(log_changes::all(), name, &LogChangeKind::name);
  LogChange change = kind.read(node);
  change.kind = &kind;
  return change;
}

}  // namespace

LogChanges LogChanges::read(const YamlNode& root) {
  const YamlNode format = root.at("format");
  if (format.text() != "simgap/change/1") {
    format.fail(fmt::format("found {}, expected simgap/change/1", format.text()));
  }
  LogChanges all;
  if (const auto name = root.find("name")) all.name = name->text();
  const YamlNode list = root.at("changes");
  for (const YamlNode& node : list.items()) all.changes.push_back(readChange(node));
  if (all.changes.empty()) list.fail("found no change, expected at least one");
  root.expectAllRead();
  return all;
}

void LogChanges::apply(LogSetting& setting, bool recorded) const {
  for (const LogChange& change : changes) {
    if (!recorded || !change.kind->shown_by_log) change.kind->apply(change, setting);
  }
}

bool LogChanges::undoes(const std::string& cause) const {
  return std::ranges::find(changes, cause, &LogChange::cause) != changes.end();
}

std::vector<std::pair<LogChanges, LogChanges>> LogChanges::withinUncertainty() const {
  std::vector<std::pair<LogChanges, LogChanges>> pairs;
  for (std::size_t c = 0; c < changes.size(); ++c) {
    for (std::size_t i = 0; i < changes[c].sizes.size(); ++i) {
      const double sd = changes[c].sds[i];
      if (sd <= 0.0) continue;
      auto& [forward, back] = pairs.emplace_back(*this, *this);
      forward.changes[c].sizes[i] += sd;
      back.changes[c].sizes[i] -= sd;
    }
  }
  return pairs;
}

void readSize(const YamlNode& node, const std::string& name, const std::string& unit, const Range& range,
              LogChange& change) {
  change.sizes.push_back(unit.empty() ? node.at(name).number(range) : node.quantity(name, unit, range));
  const std::string sd = name + "_sd";
  if (unit.empty()) {
    const auto found = node.find(sd);
    change.sds.push_back(found ? found->number(kNonNegative) : 0.0);
  } else {
    change.sds.push_back(node.findQuantity(sd, unit, kNonNegative).value_or(0.0));
  }
}

}  // namespace simgap
