/// \file
/// What a kind of joint is to files, statistics and kinematics. One file of src/core/joints per kind, found by CMake.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"
#include "simgap/core/yaml.h"

namespace simgap {

struct JointKind {
  JointType type;
  const char* name;                           ///< in files: "revolute"
  int degrees_of_freedom;                     ///< numbers that a measured position holds, too
  bool has_axis;                              ///< one coordinate about or along an axis of its own, between limits
  bool slides;                                ///< that coordinate is a way, not an angle
  std::string_view unit;                      ///< of its coordinates: "rad", "m"
  std::string_view error_unit;                ///< of its errors in reports: "deg", "mm"
  double error_size;                          ///< one of those in the unit of its coordinates
  double counted;                             ///< [rad per unit] what an error counts beside those of other joints
  double printed_error;                       ///< multiple of the error that 001 eq. 4 prints
  std::span<const std::string_view> columns;  ///< of a position in a table, behind the joint's name: "_rad"
  std::span<const std::string_view> velocity_columns;  ///< of its velocity: "_velocity_rad_s"
  const char* mjcf;                                    ///< what MuJoCo's files call it
  const char* urdf;                                    ///< what URDF calls it between limits; nullptr: it has none
  const char* sdf;                                     ///< what SDF calls it between limits

  /// The positions of that joint in a table, shape (rows). \throws DataError: a column is missing, a cell no position.
  std::vector<JointPosition> (*read)(const CsvTable& table, const std::string& joint);
  /// The same position as the cells of those columns.
  std::vector<double> (*cells)(const JointPosition& position);
  /// How far a position is from the zero pose, signed where the joint has an axis [its unit].
  double (*angle)(const JointPosition& position);
  /// The way from one position to another as a rotation vector in the parent's frame, or along the first coordinate
  /// where the joint has an axis [its unit].
  Eigen::Vector3d (*difference)(const JointPosition& from, const JointPosition& to);
  /// Distance of two positions, not below 0 [its unit].
  double (*error)(const JointPosition& a, const JointPosition& b);
  JointPosition (*mean)(std::span<const JointPosition> repeats);
  /// The position at this part of the way, 0 to 1.
  JointPosition (*between)(const JointPosition& from, const JointPosition& to, double part);
  /// The position after a small step in the child's own frame, its first coordinate where the joint has an axis.
  JointPosition (*moved)(const JointPosition& position, const Eigen::Vector3d& step);
  /// Q(q): how the child is turned in the joint's frame; axis of unit length.
  Eigen::Matrix3d (*rotation)(const Eigen::Vector3d& axis, const JointPosition& position);

  double shown(double size) const { return size / error_size; }  ///< [error_unit]
};

/// Where errors of all joints are put together, the way of a slide counts as the angle that a joint at this distance
/// would have to turn by [m]: 1 mm as 0.29 deg, about what both are captured with.
inline constexpr double kSlideLever = 0.2;

const JointKind& kindOf(JointType type);
/// Their names in our files.
std::vector<std::string> jointTypeNames();
/// The kind that a file names. \throws ConfigError: none of that name.
JointType readJointType(const YamlNode& node);

/// The kind whose name in a format, member name, mjcf, urdf or sdf, this is; nullptr: none.
const JointKind* findKind(const char* JointKind::*format, std::string_view name);

/// Error of a joint: geodesic angle in [0, pi], size of a hinge's turn [rad], distance of a slide [m].
double jointError(JointType type, const JointPosition& a, const JointPosition& b);

/// Names of the columns that hold a joint's position.
std::vector<std::string> positionColumns(JointType type, const std::string& joint);

namespace joint_kinds {
std::span<const JointKind* const> all();
}

}  // namespace simgap
