#include "motion_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

constexpr double kCommanded = 0.35;  // [rad] by which a set-point has to move
constexpr double kStands = 0.1;      // of that: a shaft that moves by less
constexpr double kFrozen = 0.5;      // [s] of the same reading, to the last digit
constexpr double kMoving = 0.05;     // a channel that repeats itself at most so often is no coarse one
constexpr double kMeanwhile = 0.15;  // [rad] by which something has to move while a channel repeats its reading
constexpr double kLatest = 0.2;      // [s] within which a channel shows what was commanded

double rangeOf(const std::vector<double>& values) {
  const auto [least, most] = std::ranges::minmax(values);
  return most - least;
}

/// The longest run of equal readings, as first sample and length. \param[out] repeats  readings that equal the one
/// before
std::pair<std::size_t, std::size_t> longestRun(std::size_t samples, const std::function<bool(std::size_t)>& same,
                                               std::size_t& repeats) {
  std::size_t first = 0, length = samples > 0 ? 1 : 0;
  repeats = 0;
  for (std::size_t i = 1, begin = 0; i < samples; ++i) {
    if (!same(i)) begin = i;
    repeats += same(i);
    if (i - begin + 1 > length) {
      length = i - begin + 1;
      first = begin;
    }
  }
  return {first, length};
}

DataFault faultOf(const std::string& channel, const std::string& sentence, std::size_t first, std::size_t rows) {
  return {channel, sentence, first + 1, first + rows, rows};
}

/// A channel over its samples.
struct Channel {
  std::string name;
  const std::vector<double>& times;             ///< shape (samples) [s]
  std::function<bool(std::size_t)> same;        ///< whether sample i equals the one before
  std::function<double(double, double)> moved;  ///< how far what it should show moves between two times [rad]
};

/// What repeats its reading while nothing moves is at rest: an encoder then shows one count.
void findFrozen(const RecordedMotion& motion, const Channel& channel, std::vector<DataFault>& faults) {
  std::size_t repeats = 0;
  const auto [first, length] = longestRun(channel.times.size(), channel.same, repeats);
  if (length < 2) return;
  const double begin = channel.times[first], lasts = channel.times[first + length - 1] - begin;
  const auto others = static_cast<double>(repeats - (length - 1));
  if (lasts < kFrozen || others > kMoving * static_cast<double>(channel.times.size())) return;
  if (channel.moved(begin, begin + lasts - kLatest) < kMeanwhile) return;
  faults.push_back(faultOf(channel.name,
                           fmt::format("motion {}: {} repeats one reading for {:.2f} s from {:.2f} s on: it hangs; "
                                       "record the motion again, or leave it out",
                                       motion.name, channel.name, lasts, begin),
                           first, length));
}

/// How far a muscle's channel moves between two times [rad]; 0 for one that is not there.
template <class Values>
double movedBetween(const std::vector<double>& times, const Values& values, double from, double to) {
  if (values.size() == 0) return 0.0;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] < from || times[i] > to) continue;
    least = std::min(least, values[i]);
    most = std::max(most, values[i]);
  }
  return std::max(0.0, most - least);
}

void findFrozenChannels(const RecordedMotion& motion, const PoseLayout& layout, std::vector<DataFault>& faults) {
  const std::vector<double>& times = motion.times();
  const auto shaftMoved = [&](std::size_t m, double from, double to) {
    return movedBetween(times, motion.muscles[m].shafts, from, to);
  };
  const auto commanded = [&](std::size_t m, double from, double to) {
    if (motion.commands.kinds[m] != CommandKind::kSetpoint) return 0.0;
    return movedBetween(times, motion.commands.values.row(m), from, to);
  };
  const auto moved = [&](std::size_t m, double from, double to) {
    return std::max(shaftMoved(m, from, to), commanded(m, from, to));
  };
  const auto look = [&](const std::string& name, const std::vector<double>& values, const auto& by) {
    if (values.empty()) return;
    const auto same = [&](std::size_t i) { return values[i] == values[i - 1]; };
    findFrozen(motion, {name, times, same, by}, faults);
  };
  for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
    look("shaft_" + layout.muscles[m] + "_rad", motion.muscles[m].shafts,
         [&](double from, double to) { return commanded(m, from, to); });
    look("current_" + layout.muscles[m] + "_A", motion.muscles[m].currents,
         [&](double from, double to) { return moved(m, from, to); });
  }
  const auto any = [&](double from, double to) {
    double most = 0.0;
    for (std::size_t m = 0; m < layout.muscles.size(); ++m) most = std::max(most, moved(m, from, to));
    return most;
  };
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const auto same = [&](std::size_t f) {
      return kindOf(layout.joints[j].type).difference(motion.joints[f - 1][j], motion.joints[f][j]).norm() == 0.0;
    };
    findFrozen(motion, {"joint " + layout.joints[j].name, motion.joint_times, same, any}, faults);
  }
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
    findFrozenChannels(motion, layout, faults);
    faulty[i] = faults.size() > before;
  }
  return faults;
}

}  // namespace simgap
