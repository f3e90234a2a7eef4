#include "simgap/measure/pose_set.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"
#include "simgap/measure/joint_columns.h"

namespace simgap {
namespace {

/// A shaft column nobody asked for is a muscle the model lacks.
void refuseUnknownMuscles(const CsvTable& table, const PoseLayout& layout) {
  for (const std::string& column : table.columns()) {
    if (!column.starts_with("shaft_")) continue;
    const std::string stem = splitUnit(column).stem;  // of shaft_rad, which names no muscle, it is shaft
    const std::string muscle = (stem.starts_with("shaft_") ? stem : column).substr(6);
    if (std::find(layout.muscles.begin(), layout.muscles.end(), muscle) == layout.muscles.end()) {
      throw DataError(fmt::format("{}:1: column {}: the model has no muscle '{}'", table.name(), column, muscle));
    }
  }
}

/// Likewise of a quantity that some line takes as its command.
void refuseUnknownLines(const CsvTable& table, const PoseLayout& layout) {
  for (const std::string& column : table.columns()) {
    const std::string stem = splitUnit(column).stem;
    const auto known = [&](const CommandChannel& line) { return line.stem == stem; };
    const auto alike = [&](const CommandChannel& line) {
      return stem.starts_with(line.stem.substr(0, line.stem.find('_') + 1));
    };
    if (std::ranges::none_of(layout.lines, alike) || std::ranges::any_of(layout.lines, known)) continue;
    const std::string name = stem.substr(stem.find('_') + 1);
    if (std::ranges::find(layout.muscles, name) != layout.muscles.end()) continue;  // the current of its motor
    throw DataError(fmt::format("{}:1: column {}: nothing in the model that takes such a command is called '{}'",
                                table.name(), column, name));
  }
}

bool holdsPosition(const CsvTable& table, const JointKind& kind, const std::string& joint) {
  const std::vector<std::string> columns = positionColumns(kind.type, joint);
  return std::all_of(columns.begin(), columns.end(), [&](const std::string& column) {
    const auto [stem, unit] = splitUnit(column);
    return table.has(column) || (!unit.empty() && table.hasQuantity(stem, unit));
  });
}

void refuseTimeGoingBack(const CsvTable& table) {
  if (!table.hasQuantity("time", "s")) return;
  const std::vector<double> time = table.quantity("time", "s");
  for (std::size_t row = 1; row < time.size(); ++row) {
    if (time[row] < time[row - 1]) {
      table.fail(row, fmt::format("time goes back: found {} s behind {} s", time[row], time[row - 1]));
    }
  }
}

struct Columns {
  std::vector<std::vector<double>> shafts;         ///< shape (muscles + lines, rows)
  std::vector<std::vector<JointPosition>> joints;  ///< shape (joints, rows)
  std::vector<double> time;                        ///< shape (rows) [s]; empty without
};

Columns readColumns(const CsvTable& table, const PoseLayout& layout) {
  Columns columns;
  for (const std::string& muscle : layout.muscles) columns.shafts.push_back(table.quantity("shaft_" + muscle, "rad"));
  for (const CommandChannel& line : layout.lines) columns.shafts.push_back(table.quantity(line.stem, line.unit));
  for (const JointChannel& joint : layout.joints) {
    columns.joints.push_back(kindOf(joint.type).read(table, joint.name));
  }
  if (table.hasQuantity("time", "s")) columns.time = table.quantity("time", "s");
  return columns;
}

Pose meanPose(const std::string& name, const std::vector<std::size_t>& rows, const Columns& columns,
              const PoseLayout& layout) {
  const auto repeats = static_cast<double>(rows.size());
  Pose pose;
  pose.name = name;
  pose.repeats = static_cast<int>(rows.size());
  for (const auto& shaft : columns.shafts) {
    double sum = 0.0;
    for (const std::size_t row : rows) sum += shaft[row];
    pose.shafts.push_back(sum / repeats);
  }
  if (!columns.time.empty()) {
    double sum = 0.0;
    for (const std::size_t row : rows) sum += columns.time[row];
    pose.time = sum / repeats;
    if (rows.front() > 0) {
      for (const auto& shaft : columns.shafts) pose.shafts_before.push_back(shaft[rows.front() - 1]);
    }
  }
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const JointType type = layout.joints[j].type;
    std::vector<JointPosition> measured;
    measured.reserve(rows.size());
    for (const std::size_t row : rows) measured.push_back(columns.joints[j][row]);
    pose.joints.push_back(kindOf(type).mean(measured));
    double squares = 0.0;
    for (const JointPosition& position : measured) {
      const double error = jointError(type, position, pose.joints.back());
      squares += error * error;
    }
    pose.spread.push_back(rows.size() > 1 ? std::sqrt(squares / (repeats - 1.0)) : 0.0);
  }
  return pose;
}

bool sameJoints(const Pose& a, const Pose& b) {
  const auto equal = [](const JointPosition& i, const JointPosition& j) {
    return i.angle == j.angle && i.rotation.coeffs() == j.rotation.coeffs();
  };
  return std::ranges::equal(a.joints, b.joints, equal);
}

bool sameReadings(const Pose& a, const Pose& b) { return a.shafts == b.shafts && sameJoints(a, b); }

/// A measurement has noise: joints that are the same to the last digit wherever the shafts stand were not measured.
void refuseStuckCapture(const PoseSet& set) {
  constexpr std::size_t kFewest = 3;
  const Pose& first = set.poses.front();
  const auto isStuck = [&](const Pose& pose) { return sameJoints(pose, first); };
  const auto isMoved = [&](const Pose& pose) { return pose.shafts != first.shafts; };
  if (set.poses.size() < kFewest || !std::ranges::all_of(set.poses, isStuck)) return;
  if (std::ranges::none_of(set.poses, isMoved)) return;
  throw DataError(fmt::format(
      "{}: found the same joint positions in all {} poses though the shafts stand elsewhere, expected joints that "
      "follow: the capture was stuck",
      set.file, set.poses.size()));
}

/// Poses of one set that are readings of the other: "q1 (p7 of before.csv)".
std::vector<std::string> copiedPoses(const PoseSet& set, const PoseSet& of) {
  std::vector<std::string> copies;
  for (const Pose& pose : set.poses) {
    const auto original = std::ranges::find_if(of.poses, [&](const Pose& other) { return sameReadings(pose, other); });
    if (original != of.poses.end()) copies.push_back(fmt::format("{} ({} of {})", pose.name, original->name, of.file));
  }
  return copies;
}

}  // namespace

void refuseOtherJointTypes(const CsvTable& table, const PoseLayout& layout) {
  for (const JointChannel& joint : layout.joints) {
    const JointKind& expected = kindOf(joint.type);
    if (holdsPosition(table, expected, joint.name)) continue;
    for (const JointKind* kind : joint_kinds::all()) {
      if (kind == &expected || !holdsPosition(table, *kind, joint.name)) continue;
      throw DataError(
          fmt::format("{}:1: joint {}: found {}, the position of a {} joint, expected {}: the model's type of it is {}",
                      table.name(), joint.name, fmt::join(positionColumns(kind->type, joint.name), ", "), kind->name,
                      fmt::join(positionColumns(expected.type, joint.name), ", "), expected.name));
    }
  }
}

PoseSet readPoseSet(const CsvTable& table, const PoseLayout& layout) {
  if (table.rows() == 0) throw DataError(fmt::format("{}: found no rows, expected at least one pose", table.name()));
  refuseUnknownMuscles(table, layout);
  refuseUnknownLines(table, layout);
  refuseOtherJointTypes(table, layout);
  const Columns columns = readColumns(table, layout);
  const std::vector<std::string> names = table.text("pose");
  const bool has_repeats = table.has("repeat");
  const std::vector<std::string> repeats = has_repeats ? table.text("repeat") : names;

  refuseTimeGoingBack(table);
  std::vector<std::string> order;
  std::map<std::string, std::vector<std::size_t>> rows_of;
  std::set<std::pair<std::string, std::string>> seen;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (names[row].empty() || repeats[row].empty()) {
      table.fail(row, fmt::format("column {}: found an empty cell", names[row].empty() ? "pose" : "repeat"));
    }
    if (!seen.emplace(names[row], repeats[row]).second) {
      table.fail(row, has_repeats ? fmt::format("pose {} repeat {} stands twice", names[row], repeats[row])
                                  : fmt::format("pose {} stands twice, and there is no column repeat", names[row]));
    }
    if (rows_of[names[row]].empty()) order.push_back(names[row]);
    rows_of[names[row]].push_back(row);
  }
  PoseSet set{table.name(), {}};
  for (const std::string& name : order) set.poses.push_back(meanPose(name, rows_of[name], columns, layout));
  refuseStuckCapture(set);
  return set;
}

void keepPosesNamed(PoseSet& set, const std::string& glob) {
  const std::string first = set.poses.front().name;
  std::erase_if(set.poses, [&](const Pose& pose) { return !matchesGlob(glob, pose.name); });
  if (!set.poses.empty()) return;
  throw DataError(fmt::format("{}: found no pose whose name matches '{}', expected one at least (a pose is '{}')",
                              set.file, glob, first));
}

std::size_t countDifferent(std::span<const Pose> poses) {
  std::size_t count = 0;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    if (std::ranges::none_of(poses.first(p), [&](const Pose& before) { return sameReadings(before, poses[p]); }))
      ++count;
  }
  return count;
}

void requireOtherPoses(const PoseSet& set, const PoseSet& others, std::string_view why) {
  const std::vector<std::string> copies = copiedPoses(set, others);
  if (2 * copies.size() <= set.poses.size()) return;
  throw DataError(
      fmt::format("{}: found {} of {} poses with readings of poses that are known already, {}, expected others: {}",
                  set.file, copies.size(), set.poses.size(), copies.front(), why));
}

}  // namespace simgap
