#include "motion_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

/// Slope of shafts over set-points through the origin, sum s c / sum c^2; 1 where nothing is commanded.
double shaftsPerSetpoint(const RecordedMotion& motion, std::size_t muscle) {
  double product = 0.0, square = 0.0;
  const std::vector<double>& shafts = motion.muscles[muscle].shafts;
  for (std::size_t row = 0; row < shafts.size(); ++row) {
    const double setpoint = motion.commands.values(static_cast<Eigen::Index>(muscle), static_cast<Eigen::Index>(row));
    product += shafts[row] * setpoint;
    square += setpoint * setpoint;
  }
  constexpr double kStill = 1e-4;  // [rad^2] mean square
  return square > kStill * static_cast<double>(shafts.size()) ? product / square : 1.0;
}

}  // namespace

void refuseClocksApart(const RecordedMotion& motion) {
  constexpr double kShortest = 0.3;  // [s]
  const std::vector<double>&commands = motion.times(), &joints = motion.joint_times;
  const double shared = std::min(commands.back(), joints.back()) - std::max(commands.front(), joints.front());
  if (shared >= kShortest) return;
  throw DataError(
      fmt::format("{}: found times from {} to {} s, expected at least {} s of them between {} and {} s, the times of "
                  "{}: the clocks "
                  "do not overlap",
                  motion.joints_file.string(), joints.front(), joints.back(), kShortest, commands.front(),
                  commands.back(), motion.muscles_file.string()));
}

void refuseShaftsApart(const RecordedMotion& motion, std::span<const std::string> muscles) {
  constexpr double kLikeDegrees = 0.2;  // of 180/pi: no controller is that far off
  for (std::size_t m = 0; m < motion.muscles.size(); ++m) {
    if (motion.commands.kinds[m] != CommandKind::kSetpoint || motion.muscles[m].shafts.empty()) continue;
    const double slope = shaftsPerSetpoint(motion, m);
    const bool setpoint = std::abs(slope / kDegree - 1.0) < kLikeDegrees;
    if (!setpoint && std::abs(slope * kDegree - 1.0) >= kLikeDegrees) continue;
    throw DataError(
        fmt::format("{}: setpoint_{}_rad: found shafts of {:.3g} times the set-points, expected about 1: {} "
                    "look like degrees",
                    motion.muscles_file.string(), muscles[m], slope, setpoint ? "the set-points" : "the shafts"));
  }
}

}  // namespace simgap
