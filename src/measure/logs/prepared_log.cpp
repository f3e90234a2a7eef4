#include "simgap/measure/logs/prepared_log.h"

#include <algorithm>

#include "prepared_rows.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap {

const LogKind& kindOf(ActuatorKind kind) { return **std::ranges::find(log_kinds::all(), kind, &LogKind::kind); }

PreparedLog prepareLog(const CsvTable& table, const Bench& bench, ActuatorKind kind, FrictionDataOptions options) {
  options.bandwidth = bench.bandwidth;
  return kindOf(kind).prepare(table, bench, options);
}

}  // namespace simgap
