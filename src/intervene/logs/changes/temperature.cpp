// Everything warmer by that much, or colder (below 0).
#include "simgap/intervene/logs/log_change.h"

namespace simgap::log_changes::temperature {
namespace {

LogChange read(const YamlNode& node) {
  LogChange change;
  // By hand: as a quantity K would be a temperature above absolute zero.
  change.sizes = {node.at("warmer_K").number(Range{-200.0, 200.0, false, "a difference in [-200, 200] K"})};
  const auto sd = node.find("warmer_sd_K");
  change.sds = {sd ? sd->number(kNonNegative) : 0.0};
  return change;
}

void apply(const LogChange& change, LogSetting& setting) { setting.warmer += change.sizes[0]; }

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"temperature", read, apply, true};

}  // namespace simgap::log_changes::temperature
