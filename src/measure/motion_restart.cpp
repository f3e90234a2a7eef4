#include "simgap/measure/motion_restart.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

constexpr double kRunUp = 0.5;  // [s]
constexpr double kAbout = 0.1;  // of samples on either side of a start [s]
constexpr std::ptrdiff_t kFewestSamples = 5;

/// Samples about a moment.
struct Window {
  std::size_t begin, end;
};
Window windowAbout(const std::vector<double>& times, double moment) {
  const auto at = [&](double time) {
    return static_cast<std::size_t>(std::ranges::lower_bound(times, time) - times.begin());
  };
  return {at(moment - kAbout), at(moment + kAbout)};
}

/// Value and slope at a moment of the parabola through samples, shape (2, components).
Eigen::Matrix<double, 2, 3> valueAndSlope(const std::vector<double>& times, Window window, double moment,
                                          const std::function<Eigen::Vector3d(std::size_t)>& sample) {
  const auto count = static_cast<Eigen::Index>(window.end - window.begin);
  Eigen::MatrixX3d powers(count, 3), values(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t s = window.begin + static_cast<std::size_t>(i);
    const double since = times[s] - moment;
    powers.row(i) << 1.0, since, since * since;
    values.row(i) = sample(s).transpose();
  }
  const Eigen::Matrix3d normal = powers.transpose() * powers;
  return (normal.ldlt().solve(powers.transpose() * values)).topRows<2>();
}

/// The state at a moment, from what was measured around it.
RecordedStart stateAt(const RecordedMotion& motion, const PoseLayout& layout, double moment) {
  RecordedStart start;
  const Window frames = windowAbout(motion.joint_times, moment), rows = windowAbout(motion.times(), moment);
  if (static_cast<std::ptrdiff_t>(frames.end - frames.begin) < kFewestSamples) {
    throw DataError(
        fmt::format("{}: motion {}: found {} frames around {:.2f} s, expected at least {} to begin anew "
                    "there (restart_s of motions: in --config)",
                    motion.joints_file.string(), motion.name, frames.end - frames.begin, moment, kFewestSamples));
  }
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const JointKind& kind = kindOf(layout.joints[j].type);
    const JointPosition& middle = motion.joints[(frames.begin + frames.end) / 2][j];
    const auto way = valueAndSlope(motion.joint_times, frames, moment,
                                   [&](std::size_t frame) { return kind.difference(middle, motion.joints[frame][j]); });
    JointPosition position = middle;
    Eigen::Vector3d velocity = way.row(1).transpose();
    if (kind.has_axis) {
      position.angle += way(0, 0);
    } else {  // the way is told in the parent's frame, a ball's velocity in the child's
      position.rotation = Eigen::Quaterniond(expSo3(way.row(0).transpose())) * middle.rotation;
      velocity = position.rotation.conjugate() * velocity;
    }
    start.joints.push_back(position);
    start.joint_velocities.push_back(velocity);
  }
  std::vector<double> commands(layout.muscles.size());
  std::size_t row = 0;
  motion.commands.at(moment, row, commands);
  for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
    const std::vector<double>& shafts = motion.muscles[m].shafts;
    if (static_cast<std::ptrdiff_t>(rows.end - rows.begin) >= kFewestSamples && !shafts.empty()) {
      const auto way = valueAndSlope(motion.times(), rows, moment,
                                     [&](std::size_t s) { return Eigen::Vector3d(shafts[s], 0.0, 0.0); });
      start.shafts.push_back(way(0, 0));
    } else if (motion.commands.kinds[m] == CommandKind::kSetpoint) {
      start.shafts.push_back(commands[m]);
    } else {
      throw DataError(
          fmt::format("{}: motion {}: found no measured shaft of {}, which is commanded by {}, expected "
                      "shaft_{}_rad to begin anew from (restart_s of motions: in --config)",
                      motion.muscles_file.string(), motion.name, layout.muscles[m],
                      columnOf(motion.commands.kinds[m]).stem, layout.muscles[m]));
    }
  }
  return start;
}

/// Rows and frames between two moments; the rows begin with the last one before, whose commands hold.
RecordedMotion between(const RecordedMotion& motion, double from, double to) {
  RecordedMotion piece = motion;
  const auto place = [](const std::vector<double>& times, double time) {
    return std::ranges::upper_bound(times, time + 1e-9) - times.begin();
  };
  const auto cut = [](auto& values, std::ptrdiff_t begin, std::ptrdiff_t end) {
    values = {values.begin() + begin, values.begin() + end};
  };
  const std::ptrdiff_t first = std::max<std::ptrdiff_t>(place(motion.times(), from) - 1, 0);
  const std::ptrdiff_t last = place(motion.times(), to);
  cut(piece.commands.times, first, last);
  piece.commands.values = motion.commands.values.middleCols(first, last - first);
  for (MuscleRecord& muscle : piece.muscles) {
    for (std::vector<double>* channel : {&muscle.shafts, &muscle.currents, &muscle.forces}) {
      if (!channel->empty()) cut(*channel, first, last);
    }
  }
  const std::ptrdiff_t first_frame = place(motion.joint_times, piece.times().front());
  const std::ptrdiff_t last_frame = place(motion.joint_times, to);
  cut(piece.joint_times, first_frame, last_frame);
  cut(piece.joints, first_frame, last_frame);
  return piece;
}

}  // namespace

MotionSet restarted(const MotionSet& set, const PoseLayout& layout, double every) {
  MotionSet pieces{set.file, {}, set.notes};
  for (const RecordedMotion& motion : set.motions) {
    const auto count = std::max(1L, std::lround(motion.duration() / every));
    const double begin = motion.times().front(), end = motion.times().back();
    const double length = motion.duration() / static_cast<double>(count);
    for (long k = 0; k < count; ++k) {
      const double from = begin + length * static_cast<double>(k), to = k + 1 < count ? from + length : end;
      if (k == 0) {
        pieces.motions.push_back(count == 1 ? motion : between(motion, begin, to));
        continue;
      }
      RecordedMotion piece = between(motion, from - kRunUp, to);
      piece.name = fmt::format("{} @ {:.4g} s", motion.name, from - begin);
      piece.start = stateAt(motion, layout, piece.times().front());
      piece.compared_from = from;
      pieces.motions.push_back(std::move(piece));
    }
  }
  return pieces;
}

}  // namespace simgap
