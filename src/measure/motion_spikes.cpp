#include "motion_spikes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "simgap/core/joint_kind.h"
#include "simgap/measure/logs/spikes.h"

namespace simgap {
namespace {

/// Frames in which a joint is far from where it is before and behind them.
std::set<std::size_t> loneFrames(const RecordedMotion& motion, std::size_t joint, const JointKind& kind) {
  std::set<std::size_t> frames;
  for (int axis = 0; axis < (kind.has_axis ? 1 : 3); ++axis) {
    std::vector<double> way;
    for (const std::vector<JointPosition>& frame : motion.joints) {
      way.push_back(kind.difference(motion.joints[0][joint], frame[joint])[axis]);
    }
    for (const Spike& spike : findSpikes(motion.joint_times, way, kMotionSpikes)) frames.insert(spike.row);
  }
  return frames;
}

/// A lone frame has others on both sides: findSpikes takes none for one that has not.
void repairJoint(RecordedMotion& motion, std::size_t joint, const JointKind& kind,
                 const std::set<std::size_t>& frames) {
  const std::vector<double>& times = motion.joint_times;
  for (const std::size_t frame : frames) {
    std::size_t before = frame, behind = frame;
    while (before > 0 && frames.contains(before)) --before;
    while (behind + 1 < times.size() && frames.contains(behind)) ++behind;
    const double part = (times[frame] - times[before]) / (times[behind] - times[before]);
    motion.joints[frame][joint] = kind.between(motion.joints[before][joint], motion.joints[behind][joint], part);
  }
}

}  // namespace

LoneReadings repairMotionSpikes(RecordedMotion& motion, const PoseLayout& layout) {
  LoneReadings lone;
  std::vector<std::string> counts;
  const auto count = [&](std::size_t spikes, const std::string& channel, std::size_t readings) {
    lone.count += spikes;
    if (spikes > 0) counts.push_back(fmt::format("{} of {} of {}", spikes, readings, channel));
  };
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const JointKind& kind = kindOf(layout.joints[j].type);
    const std::set<std::size_t> frames = loneFrames(motion, j, kind);
    repairJoint(motion, j, kind, frames);
    count(frames.size(), layout.joints[j].name, motion.joints.size());
  }
  for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
    std::vector<double>& shafts = motion.muscles[m].shafts;
    const std::vector<Spike> spikes = findSpikes(motion.times(), shafts, kMotionSpikes);
    for (const Spike& spike : spikes) shafts[spike.row] = spike.likely;
    count(spikes.size(), fmt::format("the shaft of {}", layout.muscles[m]), shafts.size());
  }
  lone.where = fmt::format("{}: {}", motion.name, fmt::join(counts, ", "));
  return lone;
}

std::string sayLoneReadings(const std::vector<LoneReadings>& motions) {
  const auto has = [](const LoneReadings& one) { return one.count > 0; };
  const auto in = std::ranges::count_if(motions, has);
  if (in == 0) return {};
  std::size_t count = 0;
  for (const LoneReadings& one : motions) count += one.count;
  const LoneReadings& most = *std::ranges::max_element(motions, {}, &LoneReadings::count);
  return fmt::format(
      "readings that stand alone were replaced by what lies between their neighbours: {} in {} of {} "
      "motions; most of motion {}",
      count, in, motions.size(), most.where);
}

}  // namespace simgap
