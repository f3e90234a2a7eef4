/// \file
/// What joints of one coordinate have in common: an angle about an axis, or a way along it.
#pragma once

#include "simgap/core/joint_kind.h"

namespace simgap::joint_kinds {

/// Of the column `<joint>_<unit>`.
inline std::vector<JointPosition> readCoordinate(const CsvTable& table, const std::string& joint,
                                                 std::string_view unit) {
  std::vector<JointPosition> positions(table.rows());
  const std::vector<double> values = table.quantity(joint, unit);
  for (std::size_t row = 0; row < values.size(); ++row) positions[row].angle = values[row];
  return positions;
}

inline std::vector<double> coordinateCells(const JointPosition& position) { return {position.angle}; }

inline double coordinate(const JointPosition& position) { return position.angle; }

inline JointPosition meanCoordinate(std::span<const JointPosition> repeats) {
  JointPosition mean;
  for (const JointPosition& repeat : repeats) mean.angle += repeat.angle / static_cast<double>(repeats.size());
  return mean;
}

inline JointPosition coordinateBetween(const JointPosition& from, const JointPosition& to, double part) {
  JointPosition position;
  position.angle = from.angle + part * (to.angle - from.angle);
  return position;
}

inline JointPosition movedCoordinate(const JointPosition& position, const Eigen::Vector3d& step) {
  JointPosition moved = position;
  moved.angle += step.x();
  return moved;
}

}  // namespace simgap::joint_kinds
