#include "simgap/measure/logs/spring_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

/// Rows in a row that hold the same value.
std::size_t endOfRun(std::span<const double> values, std::span<const int> session, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < values.size() && values[end] == values[begin] && session[end] == session[begin]) ++end;
  return end;
}

}  // namespace

SpringLog readSpringLog(CsvTable table) {
  SpringLog log;
  log.file = table.name();
  const bool length = table.hasQuantity("length", "m");
  log.angular = table.hasQuantity("deflection", "rad");
  log.own_length = length && !table.hasQuantity("deflection", "m");
  if (log.angular && (length || table.hasQuantity("deflection", "m"))) {
    throw DataError(fmt::format("{}:1: found a deflection in m and one in rad, expected one of them", log.file));
  }
  log.deflection = log.angular      ? table.takeQuantity("deflection", "rad")
                   : log.own_length ? table.takeQuantity("length", "m")
                                    : table.takeQuantity("deflection", "m");
  log.force = table.takeQuantity(log.forceName(), log.forceUnit());
  if (log.rows() == 0) throw DataError(log.file + ": found no rows, expected a log");
  log.session = readSessions(table, log.session_names);
  log.has_time = table.offersQuantity("time", "s");
  if (log.has_time) {
    log.time = table.takeQuantity("time", "s");
    requireRisingTime(table, log.time, log.session);
  } else {
    log.time.resize(log.rows());
    std::iota(log.time.begin(), log.time.end(), 0.0);
  }
  return log;
}

std::vector<std::size_t> findClipped(std::span<const double> values, std::span<const double> other,
                                     std::span<const int> session) {
  constexpr std::size_t kLeastRun = 4, kLeastRuns = 2;
  constexpr double kMoves = 12.0;  // noise levels of the other channel: more than a rest shows
  const auto [lowest, highest] = std::ranges::minmax(values);
  const auto [other_lowest, other_highest] = std::ranges::minmax(other);
  const double still = std::max(kMoves * noiseLevel(other), 0.01 * (other_highest - other_lowest));
  std::vector<std::size_t> clipped;
  for (const double limit : {lowest, highest}) {
    std::size_t runs = 0;
    for (std::size_t i = 0, end = 0; i < values.size(); i = end) {
      end = endOfRun(values, session, i);
      if (values[i] != limit || limit == 0.0 || end - i < kLeastRun) continue;
      const auto [low, high] = std::ranges::minmax(other.subspan(i, end - i));
      if (high - low > still) ++runs;
    }
    for (std::size_t i = 0; i < values.size() && runs >= kLeastRuns; ++i) {
      if (values[i] == limit) clipped.push_back(i);
    }
  }
  std::ranges::sort(clipped);
  return clipped;
}

SpringLog readSignedSpringLog(const CsvTable& table) {
  constexpr double kMirrored = -0.7;
  SpringLog spring = readSpringLog(table);
  const double r = correlation(spring.deflection, spring.force);
  if (r >= kMirrored) return spring;
  throw DataError(
      fmt::format("{}: {}_{} falls where {} grows (correlation {:.2f}), expected both to count tension as positive",
                  spring.file, spring.forceName(), spring.forceUnit(), spring.deflectionColumn(), r));
}

}  // namespace simgap
