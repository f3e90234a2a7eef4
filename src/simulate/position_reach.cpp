#include "position_reach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

constexpr double kBeyondLimit = 0.5 * std::numbers::pi;  // [rad] beyond its limits no joint is captured
constexpr double kUnlimited = 4.0 * std::numbers::pi;    // [rad]: more than any joint without limits turns
constexpr double kBeyondStop = 0.25;                     // [m] beyond its limits no slide is captured
constexpr double kLongestSlide = 10.0;                   // [m], of a slide without limits
constexpr double kOneTurn = 2.0 * std::numbers::pi;      // [rad]: beyond it angles look like degrees
constexpr double kLostFrames = 0.1;                      // share of a motion's
constexpr double kOfStart = 0.1;                         // tolerance of a start: 9 deg, 25 mm
constexpr double kClearlyOutside = 1.0 / 3.0;            // 30 deg, 83 mm
constexpr std::size_t kFewestTurned = 10;                // places by which a turned sign is told

/// What a joint's numbers may be, and what they look like where they are not.
struct Reach {
  double unlimited, beyond;
  double mistaken;                      ///< one of the unit that is confused with the right one
  double largest;                       ///< that is looked for in the right one
  const char *what, *looks_like, *end;  ///< of a column named rightly
};
Reach reachOf(const Joint& joint) {
  if (joint.slides()) return {kLongestSlide, kBeyondStop, 1e-3, 0.0, "a way in m", "millimetres", "_mm"};
  return {kUnlimited, kBeyondLimit, kDegree, kOneTurn, "an angle in rad", "degrees", "_deg"};
}

/// How far a position is outside a joint's limits [rad], of a slide [m].
double beyond(const Joint& joint, double position) {
  const double unlimited = reachOf(joint).unlimited;
  const double lower = std::max(joint.lower_limit, -unlimited), upper = std::min(joint.upper_limit, unlimited);
  return std::max({0.0, lower - position, position - upper});
}

void refuseJointOutOfReach(const Joint& joint, std::size_t j, const PlacedPositions& positions) {
  const Reach reach = reachOf(joint);
  const auto at = [&](std::size_t p) { return positions.joints(p)[j].angle; };
  const auto outside = [&](double factor, double allowed) {
    std::size_t count = 0;
    for (std::size_t p = 0; p < positions.count; ++p) count += beyond(joint, factor * at(p)) < allowed ? 0 : 1;
    return static_cast<double>(count);
  };
  const auto count = static_cast<double>(positions.count);
  const auto reached = [&](double factor) {
    return outside(factor, positions.tolerance * reach.beyond) <= positions.most_outside * count;
  };
  std::size_t farthest = 0, largest = 0;
  for (std::size_t p = 1; p < positions.count; ++p) {
    if (beyond(joint, at(p)) > beyond(joint, at(farthest))) farthest = p;
    if (std::abs(at(p)) > std::abs(at(largest))) largest = p;
  }
  // A zero that is off moves positions out of the limits on one side and keeps the other; a turned sign moves all.
  const bool turned = positions.count >= kFewestTurned && 2.0 * outside(1.0, kOfStart * reach.beyond) > count &&
                      beyond(joint, at(farthest)) > kClearlyOutside * reach.beyond &&
                      outside(-1.0, kOfStart * reach.beyond) == 0.0;
  if (reached(1.0) && !turned) return;
  std::string help;
  if (turned || reached(-1.0)) {
    help = "; its sign looks turned: positions count about the joint's axis, as the model has it";
  } else if (std::abs(at(largest)) > reach.largest && reached(reach.mistaken)) {
    help = fmt::format("; it looks like {}: name the column {}{}{}", reach.looks_like, positions.stem, joint.name,
                       reach.end);
  }
  throw DataError(fmt::format("{}: {}: {}{}_{}: found {:.6g}, expected {} within the joint's limits{}", positions.file,
                              positions.place(farthest), positions.stem, joint.name, kindOf(joint.type).unit,
                              at(farthest), reach.what, help));
}

/// A start is where the arm begins, so it has to be one that its couplings allow.
void refuseUncoupled(const ArmModel& model, std::span<const JointPosition> joints, const std::string& file,
                     const std::string& place) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (!joint.follows()) continue;
    const double expected = joint.coupling_offset + joint.coupling_ratio * joints[joint.leader].angle;
    if (std::abs(joints[j].angle - expected) <= kOfStart * reachOf(joint).beyond) continue;
    throw DataError(fmt::format("{}: {}: {}_{}: found {:.6g}, expected {:.6g}, where its coupling with {} holds it",
                                file, place, joint.name, kindOf(joint.type).unit, joints[j].angle, expected,
                                model.joints[joint.leader].name));
  }
}

}  // namespace

void refusePositionsOutOfReach(const ArmModel& model, const PlacedPositions& positions) {
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (model.joints[j].hasAxis()) refuseJointOutOfReach(model.joints[j], j, positions);
  }
}

void refuseStartOutOfReach(const ArmModel& model, std::span<const JointPosition> joints, const std::string& file,
                           const std::string& place) {
  if (joints.empty()) return;  // the model's own
  refusePositionsOutOfReach(model, {.file = file,
                                    .count = 1,
                                    .joints = [&](std::size_t) { return joints; },
                                    .place = [&](std::size_t) { return place; },
                                    .tolerance = kOfStart});
  refuseUncoupled(model, joints, file, place);
}

void refuseMotionsOutOfReach(const ArmModel& model, const MotionSet& set) {
  for (const RecordedMotion& motion : set.motions) {
    refusePositionsOutOfReach(
        model,
        {.file = motion.joints_file.string(),
         .count = motion.joints.size(),
         .joints = [&](std::size_t f) { return std::span(motion.joints[f]); },
         .place = [&](std::size_t f) { return fmt::format("motion {}, {:.6g} s", motion.name, motion.joint_times[f]); },
         .most_outside = kLostFrames});
    if (motion.start) refuseStartOutOfReach(model, motion.start->joints, set.file, "start of motion " + motion.name);
  }
}

}  // namespace simgap
