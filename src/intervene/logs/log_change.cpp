#include "simgap/intervene/logs/log_change.h"

namespace simgap {

LogChanges LogChanges::read(const YamlNode& root) { return readChanges<LogChanges>(root, log_changes::all()); }

void LogChanges::apply(LogSetting& setting, bool recorded) const {
  for (const LogChange& change : changes) {
    if (!recorded || !change.kind->shown_by_log) change.kind->apply(change, setting);
  }
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

LogChange readFactor(const YamlNode& node) {
  LogChange change;
  readSize(node, "factor", "", Range{0.01, 100.0, false, "a factor in [0.01, 100]"}, change);
  return change;
}

}  // namespace simgap
