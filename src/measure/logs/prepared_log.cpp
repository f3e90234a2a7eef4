#include "simgap/measure/logs/prepared_log.h"

#include <algorithm>

#include "prepared_rows.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap {

const LogKind& kindOf(ActuatorKind kind) { return **std::ranges::find(log_kinds::all(), kind, &LogKind::kind); }

const LogKind* log_kinds::find(std::string_view name) {
  const auto found = std::ranges::find(all(), name, &LogKind::name);
  return found == all().end() ? nullptr : *found;
}

PreparedLog prepareLog(const CsvTable& table, const Bench& bench, ActuatorKind kind, FrictionDataOptions options) {
  options.bandwidth = bench.bandwidth;
  return kindOf(kind).prepare(table, bench, options);
}

}  // namespace simgap
