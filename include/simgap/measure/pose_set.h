/// \file
/// Recorded steady-state poses: shaft angles and the joint positions the arm came to rest in (001 eq. 2).
#pragma once

#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"

namespace simgap {

/// What something other than a muscle is told to do: the column `<stem>_<unit>`, "pressure_flexor_Pa".
struct CommandChannel {
  std::string stem, unit;
};

/// What a pose set of an arm must hold: the names of its muscles and joints, in the order of the model.
struct PoseLayout {
  std::vector<std::string> muscles;
  std::vector<CommandChannel> lines;  ///< commands of lines that are not wound by a motor
  std::vector<JointChannel> joints;
};

/// One pose: the mean of its repeats.
struct Pose {
  std::string name;
  std::vector<double> shafts;         ///< shape (muscles + lines): references of the shaft controllers [rad], commands
  std::vector<JointPosition> joints;  ///< shape (joints), measured
  int repeats = 1;
  std::vector<double> spread;  ///< shape (joints) [rad]: root mean square deviation of the repeats from their
                               ///< mean with repeats - 1 in the denominator; 0 for a single repeat
  double time = std::numeric_limits<double>::quiet_NaN();  ///< mean of the repeats' time_s [s]; NaN without
  std::vector<double> shafts_before = {};  ///< of the pose recorded before it; empty for the first or without time_s
};

/// Poses in the order of their first row, with the file they came from.
struct PoseSet {
  std::string file;
  std::vector<Pose> poses;
};

/// Reads a pose set (columns: docs/formats.md, "Pose sets"). Quaternions within 1e-3 of unit length are normalised.
/// \throws DataError: a muscle of the layout without a column or a shaft column without a muscle, a quaternion that is
///         not of unit length, the same pose and repeat twice, no rows, and all that CsvTable refuses.
PoseSet readPoseSet(const CsvTable& table, const PoseLayout& layout);

/// Leaves the poses whose name matches. \throws DataError: none does.
void keepPosesNamed(PoseSet& set, const std::string& glob);

/// Poses that are no copy of one before them, readings that are the same to the last digit, whatever they are called.
std::size_t countDifferent(std::span<const Pose> poses);

/// \throws DataError: more than half of a set's poses are copies of others, readings that are the same to the last
///         digit, whatever they are called. Noise does not repeat itself.
/// \param why  what is wrong with that, for people
void requireOtherPoses(const PoseSet& set, const PoseSet& others, std::string_view why);

}  // namespace simgap
