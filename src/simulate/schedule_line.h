/// \file
/// One command over time as a schedule writes it (`simgap/schedule/1`): holds, steps, ramps and sines.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "simgap/core/yaml.h"

namespace simgap {

/// A stretch of one command: from..to linearly within `duration`, and a sine about it.
struct ScheduleSegment {
  double begin = 0.0, duration = 0.0;  ///< [s]
  double from = 0.0, to = 0.0;
  double amplitude = 0.0, frequency = 0.0, phase = 0.0;
  double at(double time) const {
    const double since = time - begin;
    const double part = duration > 0.0 ? std::clamp(since / duration, 0.0, 1.0) : 1.0;
    const double value = from + part * (to - from);
    return since < duration ? value + amplitude * std::sin(2.0 * std::numbers::pi * frequency * since + phase) : value;
  }
};

struct ScheduleLine {
  std::vector<ScheduleSegment> segments;
  double rate = 0.0;  ///< [Hz] of the rows it becomes
  double end() const { return segments.empty() ? 0.0 : segments.back().begin + segments.back().duration; }
  double last() const { return segments.empty() ? 0.0 : segments.back().to; }
  double at(double time) const {
    auto after = std::ranges::upper_bound(segments, time + 1e-9, {}, &ScheduleSegment::begin);
    return after == segments.begin() ? (segments.empty() ? 0.0 : segments.front().from) : std::prev(after)->at(time);
  }
};

/// The part of a segment that all of its kinds have. \throws ConfigError: it begins before the one above has ended
ScheduleSegment beginSegment(const YamlNode& node, const ScheduleLine& line);
/// \param unit  of the command: hold_N, step_N, … \throws ConfigError: as beginSegment; a sine that the rows cannot
/// show
ScheduleSegment readSegment(const YamlNode& node, const ScheduleLine& line, std::string_view unit);
/// How many rows a schedule has at that rate. \throws ConfigError: no time passes, or too much
std::size_t scheduleRows(const YamlNode& root, double duration, double rate);

}  // namespace simgap
