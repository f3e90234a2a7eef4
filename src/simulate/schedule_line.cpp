#include "schedule_line.h"

#include <fmt/format.h>

namespace simgap {

ScheduleSegment beginSegment(const YamlNode& node, const ScheduleLine& line) {
  ScheduleSegment segment;
  segment.begin = node.findQuantity("at", "s", kNonNegative).value_or(line.end());
  if (segment.begin < line.end() - 1e-9) {
    node.fail(fmt::format("found at_s: {:g} before the end of the segment above, {:g} s, expected times that rise",
                          segment.begin, line.end()));
  }
  segment.duration = node.findQuantity("for", "s", kNonNegative).value_or(0.0);
  segment.from = segment.to = line.last();
  return segment;
}

ScheduleSegment readSegment(const YamlNode& node, const ScheduleLine& line, std::string_view unit) {
  ScheduleSegment segment = beginSegment(node, line);
  if (const auto value = node.findQuantity("hold", unit)) {
    segment.from = segment.to = *value;
  } else if (const auto step = node.findQuantity("step", unit)) {
    segment.from = segment.to = line.last() + *step;
  } else if (const auto ramp = node.findQuantity("ramp", unit)) {
    segment.to = *ramp;
  } else if (const auto sine = node.findQuantity("sine", unit)) {
    segment.amplitude = *sine;
    segment.frequency = node.quantity("frequency", "Hz", kPositive);
    if (segment.frequency > 0.5 * line.rate) {
      node.fail(fmt::format("frequency: found {:g} Hz, expected at most {:g}: commands change {:g} times a second",
                            segment.frequency, 0.5 * line.rate, line.rate));
    }
    segment.phase = node.findQuantity("phase", "rad").value_or(0.0);
  } else {
    node.fail(fmt::format("found none of hold_{0}, step_{0}, ramp_{0} and sine_{0}, expected one", unit));
  }
  return segment;
}

std::size_t scheduleRows(const YamlNode& root, double duration, double rate) {
  constexpr double kMostRows = 1e7;
  if (!(duration > 0.0)) root.fail("found no time that passes, expected duration_s or segments with for_s");
  if (!(duration * rate < kMostRows)) {
    root.fail(fmt::format("found {:g} s at {:g} Hz, expected at most {:g} rows", duration, rate, kMostRows));
  }
  return static_cast<std::size_t>(std::lround(duration * rate)) + 1;
}

}  // namespace simgap
