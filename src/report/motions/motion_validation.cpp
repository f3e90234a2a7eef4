#include <fmt/format.h>

#include "motion_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

struct ChannelUnit {
  std::string_view unit;
  double factor;  ///< from SI
};
ChannelUnit unitOf(const ErrorSeries& series, const PoseLayout& layout) {
  if (series.group == ChannelGroup::kCurrent) return {"A", 1.0};
  if (series.group == ChannelGroup::kShaft) return {"deg", 1.0 / kDegree};
  const JointKind& kind = kindOf(layout.joints[series.item].type);
  return {kind.error_unit, kind.shown(1.0)};
}

std::string channelName(const ErrorSeries& series, const PoseLayout& layout) {
  if (series.group == ChannelGroup::kJoint) return layout.joints[series.item].name;
  return (series.group == ChannelGroup::kShaft ? "shaft_" : "current_") + layout.muscles[series.item];
}

double noiseOf(const ErrorSeries& series, const MotionNoise& noise) {
  if (series.group == ChannelGroup::kJoint) return noise.joints[series.item];
  return series.group == ChannelGroup::kShaft ? noise.shafts : noise.currents;
}

Json channelsJson(const MotionValidationResult& result, std::size_t m) {
  Json channels = Json::array();
  for (const ErrorSeries& series : errorSeries(result.set.motions[m], result.played[m], result.layout)) {
    const ChannelError error = summarise(series);
    const ChannelUnit unit = unitOf(series, result.layout);
    channels.push_back({{"motion", result.set.motions[m].name},
                        {"channel", channelName(series, result.layout)},
                        {"unit", unit.unit},
                        {"rms", unit.factor * error.rms},
                        {"noise", unit.factor * noiseOf(series, result.noise)},
                        {"worst_second", unit.factor * error.worst_second},
                        {"worst_at_s", error.worst_at},
                        {"lag_ms", numberOrNull(1e3 * error.lag)}});
  }
  return channels;
}

}  // namespace

Json toJson(const MotionValidationResult& result) {
  Json motions = Json::array();
  for (std::size_t m = 0; m < result.set.motions.size(); ++m) {
    const RecordedMotion& motion = result.set.motions[m];
    const bool valid = result.played[m].valid;
    const MotionRms rms = motionRms({&motion, 1}, {&result.played[m], 1}, result.layout);
    motions.push_back({{"name", motion.name},
                       {"duration_s", motion.duration()},
                       {"valid", valid},
                       {"rms", rmsJson(rms, result.layout)},
                       {"channels", valid ? channelsJson(result, m) : Json::array()}});
  }
  Json criteria = Json::array();
  for (const Criterion& c : result.criteria) {
    criteria.push_back({{"name", c.name}, {"limit", c.limit}, {"value", numberOrNull(c.value)}, {"pass", c.pass()}});
  }
  const MotionRms noise{result.noise.joints, result.noise.shafts, result.noise.currents};
  return {{"format", "simgap/validate-motions/1"},
          {"motion_rms", rmsJson(result.rms, result.layout)},
          {"noise", rmsJson(noise, result.layout)},
          {"motions", motions},
          {"criteria", criteria}};
}

std::string motionErrorsCsv(const MotionValidationResult& result) {
  CsvWriter csv({"motion", "channel", "unit", "rms", "noise", "worst_second", "worst_at_s", "lag_ms"});
  const Json json = toJson(result);
  for (const Json& motion : json.at("motions")) {
    for (const Json& c : motion.at("channels")) {
      for (const char* text : {"motion", "channel", "unit"}) csv.add(c.at(text).get<std::string>());
      for (const char* number : {"rms", "noise", "worst_second", "worst_at_s", "lag_ms"}) {
        c.at(number).is_null() ? csv.add("") : csv.add(c.at(number).get<double>());
      }
      csv.endRow();
    }
  }
  return csv.text();
}

std::string terminalTable(const MotionValidationResult& result) {
  const Json json = toJson(result);
  const Table rms = validationRms(json), worst = worstChannels(json);
  std::string text = rms.caption + "\n" + alignedTable(rms) + "\n" + worst.caption + "\n" + alignedTable(worst);
  for (const Criterion& c : result.criteria) {
    text += fmt::format("{}: {:.3f}, limit {:g}: {}\n", c.name, c.value, c.limit, c.pass() ? "holds" : "fails");
  }
  return text;
}

std::string residualsCsv(const PoseLayout& layout, const std::vector<PlayedSet>& sets) {
  CsvWriter csv({"set", "motion", "model", "joint", "unit", "time_s", "error"});
  if (sets.empty()) return csv.text();
  // The models of a set follow each other motion by motion: one chart shows them together.
  std::vector<std::string> names;
  for (const PlayedSet& set : sets) {
    if (std::ranges::find(names, set.set) == names.end()) names.push_back(set.set);
  }
  for (const std::string& name : names) {
    const auto first = std::ranges::find(sets, name, &PlayedSet::set);
    for (std::size_t m = 0; m < first->motions->motions.size(); ++m) {
      for (const PlayedSet& set : sets) {
        if (set.set != name || !(*set.played)[m].valid) continue;
        const RecordedMotion& motion = set.motions->motions[m];
        for (const ErrorSeries& series : errorSeries(motion, (*set.played)[m], layout)) {
          if (series.group != ChannelGroup::kJoint) continue;
          const JointKind& kind = kindOf(layout.joints[series.item].type);
          for (std::size_t i = 0; i < series.times.size(); ++i) {
            csv.add(name).add(motion.name).add(set.model).add(layout.joints[series.item].name);
            csv.add(std::string(kind.error_unit)).add(series.times[i]);
            csv.add(kind.shown(series.errors[i].norm())).endRow();
          }
        }
      }
    }
  }
  return csv.text();
}

}  // namespace simgap
