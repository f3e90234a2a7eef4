/// \file
/// What readers and writers of all formats share about arms.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "simgap/model/arm/arm.h"

namespace simgap {

/// A rotation without the noise of having been multiplied: exactly the identity where it is that but for rounding.
Eigen::Quaterniond tidyRotation(const Eigen::Matrix3d& rotation);
/// A unit vector, exactly along an axis where it is that but for rounding.
Eigen::Vector3d tidyAxis(Eigen::Vector3d axis);

/// The child in the parent at position 0 of the joint.
Eigen::Isometry3d drawnPose(const Joint& joint);

/// Mass properties in a body's frame as a part of it.
Part statedPart(const std::string& name, const MassProperties& mass);
std::string freePartName(const Body& body, const std::string& wanted);

/// q of `joint` = offset + ratio q of `of`. A joint follows one that stands before it: the line is turned round where
/// it has to be. \throws DataError at `place`: tied twice, to itself, or by 0
void tieJoints(ArmModel& model, int joint, int of, double ratio, double offset, const std::string& place);

/// The kind of passive tendon of that name.
const TendonKind* tendonKind(std::string_view name);

/// What no file of the field says about a muscle, from the sample arm; its line is just taut at shaft 0 when its path
/// is `length` long.
Muscle placeholderMuscle(double length);
inline constexpr std::string_view kPlaceholders =
    "a motorised muscle whose cord, spindle, motor and gearbox are placeholders: enter yours";

/// Adds a placeholder along a path of that length, with its motor and gearbox as those of all muscles.
Muscle& addPlaceholderMuscle(ArmModel& arm, const TendonPath& path, const std::string& name, double length);

/// Where what an arm consists of stands in the given file, "robot.xml:12", by its list and name: "bodies tip".
using ArmPlaces = std::map<std::string, std::string>;

/// \throws DataError: a body that moves has no mass, nor has anything that hangs on it
void checkMasses(const ArmModel& model, const std::filesystem::path& file, const ArmPlaces& places);

/// The arm as it reads back from its own file, so that what is wrong with it is found now.
/// \throws DataError "FILE:LINE: body 'tip': …"; without a line where `places` knows none
ArmModel checkedArm(ArmModel model, const std::filesystem::path& file, const ArmPlaces& places);

}  // namespace simgap
