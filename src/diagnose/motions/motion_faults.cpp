#include "motion_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

constexpr double kCommanded = 0.35;  // [rad] by which a set-point has to move
constexpr double kStands = 0.1;      // of that: a shaft that moves by less
constexpr double kFrozen = 0.5;      // [s] of the same reading, to the last digit
constexpr double kMoving = 0.05;     // a channel that repeats itself at most so often is no coarse one

double rangeOf(const std::vector<double>& values) {
  const auto [least, most] = std::ranges::minmax(values);
  return most - least;
}

/// The longest run of equal readings, as first sample and length.
template <class Same>
std::pair<std::size_t, std::size_t> longestRun(std::size_t samples, const Same& same, std::size_t& repeats) {
  std::size_t first = 0, best = 0, length = samples > 0 ? 1 : 0;
  repeats = 0;
  for (std::size_t i = 1, begin = 0; i < samples; ++i) {
    if (!same(i)) begin = i;
    repeats += same(i);
    if (i - begin + 1 > length) {
      length = i - begin + 1;
      best = begin;
    }
  }
  first = best;
  return {first, length};
}

DataFault faultOf(const std::string& channel, const std::string& sentence, std::size_t first, std::size_t rows) {
  return {channel, sentence, first + 1, first + rows, rows};
}

/// \param same  whether sample i equals the one before
template <class Same>
void findFrozen(const RecordedMotion& motion, const std::string& channel, const std::vector<double>& times,
                const Same& same, std::vector<DataFault>& faults) {
  std::size_t repeats = 0;
  const auto [first, length] = longestRun(times.size(), same, repeats);
  if (length < 2) return;
  const double lasts = times[first + length - 1] - times[first];
  const auto others = static_cast<double>(repeats - (length - 1));
  if (lasts < kFrozen || others > kMoving * static_cast<double>(times.size())) return;
  faults.push_back(faultOf(channel,
                           fmt::format("motion {}: {} repeats one reading for {:.2f} s from {:.2f} s on: it hangs; "
                                       "record the motion again, or leave it out",
                                       motion.name, channel, lasts, times[first]),
                           first, length));
}

void findStuckShafts(const RecordedMotion& motion, const PoseLayout& layout, std::vector<DataFault>& faults) {
  std::vector<std::size_t> stuck;
  std::size_t follow = 0;
  for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
    const std::vector<double>& shafts = motion.muscles[m].shafts;
    if (shafts.empty() || motion.commands.kinds[m] != CommandKind::kSetpoint) continue;
    const auto row = motion.commands.values.row(m);
    const double commanded = row.maxCoeff() - row.minCoeff();
    if (commanded < kCommanded) continue;
    (rangeOf(shafts) < kStands * commanded ? stuck.push_back(m) : void(++follow));
  }
  if (follow == 0) return;
  for (const std::size_t m : stuck) {
    const auto row = motion.commands.values.row(m);
    faults.push_back(
        faultOf("shaft_" + layout.muscles[m] + "_rad",
                fmt::format("motion {}: the shaft of {} stands (within {:.1f} deg) while its set-point moves by {:.0f} "
                            "deg and other shafts follow theirs: it is stuck, or its sensor is; record the motion "
                            "again, or leave it out",
                            motion.name, layout.muscles[m], toDegrees(rangeOf(motion.muscles[m].shafts)),
                            toDegrees(row.maxCoeff() - row.minCoeff())),
                0, motion.times().size()));
  }
}

}  // namespace

std::vector<DataFault> findMotionFaults(const MotionSet& set, const PoseLayout& layout, std::vector<bool>& faulty) {
  std::vector<DataFault> faults;
  faulty.assign(set.motions.size(), false);
  for (std::size_t i = 0; i < set.motions.size(); ++i) {
    const RecordedMotion& motion = set.motions[i];
    const std::size_t before = faults.size();
    findStuckShafts(motion, layout, faults);
    for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
      const auto look = [&](const std::string& name, const std::vector<double>& values) {
        if (values.empty()) return;
        findFrozen(
            motion, name, motion.times(), [&](std::size_t r) { return values[r] == values[r - 1]; }, faults);
      };
      look("shaft_" + layout.muscles[m] + "_rad", motion.muscles[m].shafts);
      look("current_" + layout.muscles[m] + "_A", motion.muscles[m].currents);
    }
    for (std::size_t j = 0; j < layout.joints.size(); ++j) {
      const auto same = [&](std::size_t f) {
        return kindOf(layout.joints[j].type).difference(motion.joints[f - 1][j], motion.joints[f][j]).norm() == 0.0;
      };
      findFrozen(motion, "joint " + layout.joints[j].name, motion.joint_times, same, faults);
    }
    faulty[i] = faults.size() > before;
  }
  return faults;
}

}  // namespace simgap
