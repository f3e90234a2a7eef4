#include "pose_plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "position_reach.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/statistics.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/possible_commands.h"

namespace simgap {
namespace {

constexpr double kContradicted = 45.0 * kDegree;      // mean error of a reading that is in doubt,
constexpr double kClearlyBetter = 0.5;                // and what of it the other reading may leave
constexpr double kTwoTurns = 4.0 * std::numbers::pi;  // [rad] of a shaft
constexpr double kGoesWith = 0.6;                     // correlation of a joint with its model's,
constexpr std::size_t kFewestTold = 10;               // poses by which that is told,
constexpr double kAlikeFar = 2.0;                     // and up to how many times as far either goes as the other
constexpr double kLeastPressure = 1000.0;             // [Pa]
constexpr std::size_t kLooked = 40;                   // poses, enough for a mean

void refuseShaftsOutOfReach(const ArmModel& model, const PoseSet& set) {
  const auto reachable = [&](double factor) {
    return std::ranges::all_of(set.poses, [&](const Pose& pose) {
      for (std::size_t m = 0; m < model.muscles.size(); ++m) {
        if (windsTooFar(model.muscles[m], factor * pose.shafts[m])) return false;
      }
      return true;
    });
  };
  if (reachable(1.0)) return;
  const char* help = reachable(kDegree) ? "; they look like degrees: name the columns shaft_<muscle>_deg" : "";
  for (const Pose& pose : set.poses) {
    for (std::size_t m = 0; m < model.muscles.size(); ++m) {
      const Muscle& muscle = model.muscles[m];
      if (!windsTooFar(muscle, pose.shafts[m])) continue;
      throw DataError(fmt::format(
          "{}: pose {}: shaft_{}_rad: found {:.6g}, which winds {:.3g} m of line, expected angles in rad that a muscle "
          "of "
          "{:.3g} m allows{}",
          set.file, pose.name, muscle.name, pose.shafts[m], muscle.spindle_radius * std::abs(pose.shafts[m]),
          muscle.kite_line_length + muscle.shock_cord.rest_length, help));
    }
  }
}

/// A pneumatic muscle moves nothing below a hundredth of a bar.
void refusePressuresInBar(const ArmModel& model, const PoseSet& set) {
  const std::vector<CommandChannel> lines = model.poseLayout().lines;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (lines[k].unit != "Pa") continue;
    double highest = 0.0;
    for (const Pose& pose : set.poses) highest = std::max(highest, pose.shafts[model.muscles.size() + k]);
    if (highest == 0.0 || highest > kLeastPressure) continue;
    throw DataError(
        fmt::format("{}: {}_Pa: found at most {:.6g}, expected pressures in Pa; they look like bar: name the "
                    "column {}_bar",
                    set.file, lines[k].stem, highest, lines[k].stem));
  }
}

/// A joint follows its servo: targets of more than two turns, where no joint makes one, are in degrees.
void refuseTargetsInDegrees(const ArmModel& model, const PoseSet& set) {
  const std::vector<CommandChannel> lines = model.poseLayout().lines;
  double farthest = 0.0;
  for (const Pose& pose : set.poses) {
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      if (!model.joints[j].slides()) farthest = std::max(farthest, std::abs(pose.joints[j].angle));
    }
  }
  if (farthest > 0.5 * kTwoTurns) return;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (lines[k].unit != "rad") continue;
    for (const Pose& pose : set.poses) {
      const double target = pose.shafts[model.muscles.size() + k];
      if (std::abs(target) <= kTwoTurns) continue;
      throw DataError(
          fmt::format("{}: pose {}: {}_rad: found {:.6g}, more than two turns where no joint makes one; targets in "
                      "degrees? name the column {}_deg",
                      set.file, pose.name, lines[k].stem, target, lines[k].stem));
    }
  }
}

void refusePosesOutOfReach(const ArmModel& model, const PoseSet& set) {
  refusePositionsOutOfReach(model, {.file = set.file,
                                    .count = set.poses.size(),
                                    .joints = [&](std::size_t p) { return std::span(set.poses[p].joints); },
                                    .place = [&](std::size_t p) { return "pose " + set.poses[p].name; }});
}

/// Rotation vectors of a ball, measured x and the model's y.
struct TurnsOfABall {
  double products = 0.0, measured = 0.0, of_model = 0.0;  ///< sums over poses of x y, x^2, y^2
  void add(const Eigen::Quaterniond& read, const Eigen::Quaterniond& meant) {
    const Eigen::Vector3d x = logSo3(read), y = logSo3(meant);
    products += x.dot(y);
    measured += x.squaredNorm();
    of_model += y.squaredNorm();
  }
  double correlation() const { return products / std::sqrt(std::max(measured * of_model, 1e-300)); }
};

/// Mean error per joint of the model against poses as they stand and read another way, over poses with equilibria for
/// both.
struct Readings {
  std::vector<double> as_is, shafts_in_degrees, order_xyzw;  ///< shape (joints) [rad], as counted
  std::vector<std::vector<double>> measured, of_model;       ///< shape (joints, poses) [rad], of hinges
  std::vector<TurnsOfABall> balls;                           ///< shape (joints)
};

/// What was meant by a quaternion whose cells stand in the order x, y, z, w.
JointPosition fromXyzw(const JointPosition& read) {
  const Eigen::Quaterniond& q = read.rotation;
  return {Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()), read.angle};
}

Readings compareReadings(const ArmModel& model, const PoseSet& set) {
  const std::size_t joints = model.joints.size();
  const std::vector<double> none(joints, 0.0);
  const std::vector<std::vector<double>> no_poses(joints);
  Readings mean{none, none, none, no_poses, no_poses, std::vector<TurnsOfABall>(joints)};
  EquilibriumArm arm(model), other(model);
  std::vector<double> degrees;
  int count = 0;
  for (std::size_t p = 0; p < std::min(kLooked, set.poses.size()); ++p) {
    const Pose& pose = set.poses[p];
    degrees = pose.shafts;
    for (std::size_t m = 0; m < model.muscles.size(); ++m) degrees[m] *= kDegree;
    for (EquilibriumArm* each : {&arm, &other}) each->setHistory(pose.time, pose.shafts_before);
    if (!arm.solve(pose.shafts).stable || !other.solve(degrees).stable) continue;
    ++count;
    for (std::size_t j = 0; j < joints; ++j) {
      const JointType type = model.joints[j].type;
      const double counted = kindOf(type).counted;
      const JointPosition& at = arm.joints()[j];
      mean.as_is[j] += counted * jointError(type, pose.joints[j], at);
      mean.shafts_in_degrees[j] += counted * jointError(type, pose.joints[j], other.joints()[j]);
      mean.order_xyzw[j] += counted * jointError(type, fromXyzw(pose.joints[j]), at);
      mean.measured[j].push_back(pose.joints[j].angle);
      mean.of_model[j].push_back(at.angle);
      if (!model.joints[j].hasAxis()) mean.balls[j].add(pose.joints[j].rotation, at.rotation);
    }
  }
  for (std::vector<double>* of : {&mean.as_is, &mean.shafts_in_degrees, &mean.order_xyzw}) {
    for (double& error : *of) error /= std::max(1, count);
  }
  return mean;
}

double largestShaft(const ArmModel& model, const PoseSet& set) {
  double largest = 0.0;
  for (const Pose& pose : set.poses) {
    for (std::size_t m = 0; m < model.muscles.size(); ++m) largest = std::max(largest, std::abs(pose.shafts[m]));
  }
  return largest;
}

bool clearlyWrong(double as_is, double other) { return as_is > kContradicted && other < kClearlyBetter * as_is; }

/// A joint that moves as the model says, but 57 times less far.
void refuseJointsInRadians(const ArmModel& model, const PoseSet& set, const Readings& readings) {
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const std::vector<double>&read = readings.measured[j], &of_model = readings.of_model[j];
    if (!joint.hasAxis() || joint.slides() || read.size() < kFewestTold) continue;
    if (!(correlation(read, of_model) > kGoesWith)) continue;
    const double moved = standardDeviation(read), meant = standardDeviation(of_model), as_radians = toDegrees(moved);
    if (as_radians * kAlikeFar < meant || as_radians > kAlikeFar * meant) continue;
    throw DataError(
        fmt::format("{}: {}_deg: found angles that look like radians: read as named the joint goes {:.2g} deg to and "
                    "fro where the model goes {:.2g} deg; name the column {}_rad",
                    set.file, joint.name, toDegrees(moved), toDegrees(meant), joint.name));
  }
}

/// A ball that turns against the model's.
void refuseInvertedQuaternions(const ArmModel& model, const PoseSet& set, const Readings& readings) {
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const TurnsOfABall& ball = readings.balls[j];
    if (readings.measured[j].size() < kFewestTold || !(ball.correlation() < -kGoesWith)) continue;
    const std::string& name = model.joints[j].name;
    throw DataError(fmt::format(
        "{}: {}_qw, {}_qx, {}_qy, {}_qz: found turns against the model's (correlation {:.2f}), expected how the child "
        "is turned in the parent; they look like the parent in the child: write the quaternions' conjugates",
        set.file, name, name, name, name, ball.correlation()));
  }
}

void refuseOtherReadings(const ArmModel& model, const PoseSet& set) {
  const Readings readings = compareReadings(model, set);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (model.joints[j].hasAxis()) continue;
    if (!clearlyWrong(readings.as_is[j], readings.order_xyzw[j])) continue;
    const std::string& name = model.joints[j].name;
    throw DataError(fmt::format(
        "{}: {}_qw, {}_qx, {}_qy, {}_qz: found quaternions that look like x, y, z, w (as ROS writes them), expected w, "
        "x, "
        "y, z: read as named they lie {:.0f} deg from where the model rests, read as x, y, z, w {:.0f} deg; name the "
        "columns by what they hold",
        set.file, name, name, name, name, toDegrees(readings.as_is[j]), toDegrees(readings.order_xyzw[j])));
  }
  refuseInvertedQuaternions(model, set, readings);
  refuseJointsInRadians(model, set, readings);
  const auto worst = [](const std::vector<double>& errors) { return *std::ranges::max_element(errors); };
  // A wrong model may be worse than an arm that hardly moves, which is what shafts in degrees make of it; but shafts
  // that make two turns and more are rare, and angles in degrees are not.
  if (largestShaft(model, set) > kTwoTurns && clearlyWrong(worst(readings.as_is), worst(readings.shafts_in_degrees))) {
    throw DataError(
        fmt::format("{}: shaft_<muscle>_rad: found angles that look like degrees, expected rad: read as rad the model "
                    "rests {:.0f} deg "
                    "from the poses, read as degrees {:.0f} deg; name the columns shaft_<muscle>_deg",
                    set.file, toDegrees(worst(readings.as_is)), toDegrees(worst(readings.shafts_in_degrees))));
  }
}

}  // namespace

void refuseImplausiblePoses(const ArmModel& model, const PoseSet& set) {
  refuseShaftsOutOfReach(model, set);
  refusePressuresInBar(model, set);
  refuseTargetsInDegrees(model, set);
  refusePosesOutOfReach(model, set);
  refuseOtherReadings(model, set);
}

}  // namespace simgap
