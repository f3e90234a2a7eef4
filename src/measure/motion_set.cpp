#include "simgap/measure/motion_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "motion_checks.h"
#include "motion_spikes.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/measure/joint_columns.h"

namespace simgap {
namespace {

MuscleRecord readMuscle(const CsvTable& table, const std::string& muscle) {
  const auto measured = [&](const std::string& stem, std::string_view unit) {
    return table.offersQuantity(stem, unit) ? table.quantity(stem, unit) : std::vector<double>();
  };
  return {measured("shaft_" + muscle, "rad"), measured("current_" + muscle, "A"),
          measured("measured_force_" + muscle, "N")};
}

void expectTwoRows(const CsvTable& table) {
  if (table.rows() >= 2) return;
  throw DataError(fmt::format("{}: found {} rows, expected at least 2", table.name(), table.rows()));
}

void readMuscles(const CsvTable& table, const PoseLayout& layout, RecordedMotion& motion) {
  constexpr std::array<std::string_view, 3> kMeasured = {"shaft", "current", "measured_force"};
  expectTwoRows(table);
  refuseForeignMuscles(table, layout, kMeasured);
  motion.commands = readCommands(table, layout, motion.commands.linear);
  for (const std::string& muscle : layout.muscles) motion.muscles.push_back(readMuscle(table, muscle));
}

void readJoints(const CsvTable& table, const PoseLayout& layout, RecordedMotion& motion) {
  refuseOtherJointTypes(table, layout);
  expectTwoRows(table);
  motion.joint_times = readRisingTimes(table);
  motion.joints.assign(motion.joint_times.size(), {});
  for (const JointChannel& joint : layout.joints) {
    const std::vector<JointPosition> positions = kindOf(joint.type).read(table, joint.name);
    for (std::size_t f = 0; f < positions.size(); ++f) motion.joints[f].push_back(positions[f]);
  }
}

/// Speed of a joint over its first frames by a straight line, with its standard error [per second].
struct Drift {
  double speed = 0.0, error = 0.0;
};
Drift driftOf(const RecordedMotion& motion, std::size_t joint, JointType type, std::size_t frames) {
  const auto n = static_cast<double>(frames);
  double mean_time = 0.0;
  for (std::size_t f = 0; f < frames; ++f) mean_time += motion.joint_times[f] / n;
  std::vector<Eigen::Vector3d> way;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), slope = Eigen::Vector3d::Zero();
  double spread = 0.0;
  for (std::size_t f = 0; f < frames; ++f) {
    way.push_back(kindOf(type).difference(motion.joints[0][joint], motion.joints[f][joint]));
    mean += way.back() / n;
    const double dt = motion.joint_times[f] - mean_time;
    slope += dt * way.back();
    spread += dt * dt;
  }
  slope /= spread;
  double squares = 0.0;
  for (std::size_t f = 0; f < frames; ++f) {
    squares += (way[f] - mean - slope * (motion.joint_times[f] - mean_time)).squaredNorm();
  }
  const double freedom = (n - 2.0) * kindOf(type).degrees_of_freedom;
  return {slope.norm(), std::sqrt(kindOf(type).degrees_of_freedom * squares / freedom / spread)};
}

/// A motion that is said to start at rest: while the commands stand still, no joint may move far beyond its noise.
void refuseMovingStart(const RecordedMotion& motion, const PoseLayout& layout) {
  constexpr double kWindow = 0.25;          // [s]
  constexpr std::size_t kFewest = 6;        // frames that tell a speed
  constexpr double kFast = 10.0 * kDegree;  // [rad/s], of a slide as JointKind::counted
  constexpr double kCertain = 5.0;          // standard errors
  const double end = std::min(firstChange(motion), motion.times().front() + kWindow);
  std::size_t frames = 0;
  while (frames < motion.joint_times.size() && motion.joint_times[frames] <= end) ++frames;
  if (frames < kFewest) return;
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const JointKind& kind = kindOf(layout.joints[j].type);
    const Drift drift = driftOf(motion, j, layout.joints[j].type, frames);
    if (kind.counted * drift.speed < kFast || drift.speed < kCertain * drift.error) continue;
    throw DataError(
        fmt::format("{}: motion {} starts moving: found {} at {:.0f} {}/s in its first {:.2f} s, before any "
                    "command changes; expected an arm at rest (or start: with its state)",
                    motion.joints_file.string(), motion.name, layout.joints[j].name, kind.shown(drift.speed),
                    kind.error_unit, motion.joint_times[frames - 1] - motion.joint_times[0]));
  }
}

/// `joints: {shoulder: [w, x, y, z], elbow_rad: 0.7, rail_m: 0.1}`, `shafts: {biceps_rad: 3.1, …}`.
RecordedStart readStart(const YamlNode& node, const PoseLayout& layout) {
  RecordedStart start;
  const YamlNode joints = node.at("joints");
  for (const JointChannel& joint : layout.joints) {
    JointPosition position;
    if (kindOf(joint.type).has_axis) {
      position.angle = joints.quantity(joint.name, kindOf(joint.type).unit);
    } else {
      position.rotation = joints.at(joint.name).unitQuaternion().normalized();
    }
    start.joints.push_back(position);
  }
  if (layout.muscles.empty()) return start;
  const YamlNode shafts = node.at("shafts");
  for (const std::string& muscle : layout.muscles) start.shafts.push_back(shafts.quantity(muscle, "rad"));
  return start;
}

RecordedMotion readMotion(const YamlNode& node, const std::filesystem::path& folder, const PoseLayout& layout) {
  RecordedMotion motion;
  motion.name = node.at("name").text();
  if (motion.name.empty()) node.at("name").fail("found an empty text, expected a name");
  motion.muscles_file = folder / node.at("muscles").text();
  motion.joints_file = folder / node.at("joints").text();
  if (const auto hold = node.find("hold")) motion.commands.linear = hold->oneOf({"step", "linear"}) == "linear";
  if (const auto weight = node.find("weight")) motion.weight = weight->number(kPositive);
  if (const auto start = node.find("start"); start && start->isScalar()) {
    start->oneOf({"rest"});
  } else if (start) {
    motion.start = readStart(*start, layout);
  }
  return motion;
}

}  // namespace

double firstChange(const RecordedMotion& motion) {
  const Eigen::MatrixXd& values = motion.commands.values;
  Eigen::Index first = 1;
  while (first < values.cols() && values.col(first) == values.col(0)) ++first;
  if (first == values.cols()) return motion.times().back();
  // Straight ones begin to change behind the row before.
  return motion.times()[motion.commands.linear ? first - 1 : first];
}

MotionSet readMotionSet(const YamlNode& root, const std::filesystem::path& file, const PoseLayout& layout,
                        const TableReader& table) {
  root.at("format").oneOf({"simgap/motions/1"});
  const YamlNode list = root.at("motions");
  MotionSet set{file.string(), {}};
  std::set<std::string> names;
  for (const YamlNode& node : list.items()) {
    set.motions.push_back(readMotion(node, file.parent_path(), layout));
    if (!names.insert(set.motions.back().name).second) {
      node.at("name").fail(fmt::format("'{}' stands twice, expected a name for each motion", set.motions.back().name));
    }
  }
  root.expectAllRead();
  if (set.motions.empty()) list.fail("found no motion, expected at least one");
  std::vector<LoneReadings> lone;
  for (RecordedMotion& motion : set.motions) {
    readMuscles(table(motion.muscles_file), layout, motion);
    readJoints(table(motion.joints_file), layout, motion);
    refuseClocksApart(motion);
    lone.push_back(repairMotionSpikes(motion, layout));
    refuseShaftsApart(motion, layout.muscles);
    if (!motion.start) refuseMovingStart(motion, layout);
  }
  if (std::string note = sayLoneReadings(lone); !note.empty()) set.notes.push_back(std::move(note));
  return set;
}

}  // namespace simgap
