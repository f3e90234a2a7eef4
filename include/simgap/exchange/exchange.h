/// \file
/// Robots of the field's formats: MJCF (MuJoCo) and URDF into an arm and out of it, SDF into one. What one side has no
/// place for is named, never dropped in silence.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/model/arm/arm.h"

namespace simgap {

/// Something that the other side has no place for, or holds in another way, and what was done about it.
struct ExchangeRemark {
  std::string what;                 ///< "joint armature"
  std::string done;                 ///< "left out: a joint has no rotor of its own"
  bool matters = true;              ///< the robot rests or moves otherwise; false for looks, solvers, names
  std::vector<std::string> places;  ///< "finger.xml:12", in the order of the file; empty for what stands in no file
};

struct ImportedArm {
  ArmModel model;
  std::vector<ExchangeRemark> remarks;
};

struct ExportedArm {
  std::string text;
  std::vector<ExchangeRemark> remarks;
};

/// Gives the text of a file that another one includes. \throws Error when it cannot be read
using FileReader = std::function<std::string(const std::filesystem::path&)>;

/// An MJCF model. Bodies with several joints become several bodies, of which the last has the mass.
/// \param read  for <include>; what is asked for stands on a relative way from the folder of `file`, each file once
/// \throws DataError "FILE:LINE: ELEMENT: …": no XML, what means nothing (a tendon with one site, NaN), or what an arm
///         cannot be (floating bases, closed loops)
ImportedArm readMjcf(const std::string& text, const std::filesystem::path& file, const FileReader& read);

/// A URDF robot: bodies and joints, without muscles. Its root link stands still. \throws DataError as readMjcf
ImportedArm readUrdf(const std::string& text, const std::filesystem::path& file);

/// The model with joints of an SDF file: bodies and joints, without muscles. \throws DataError as readMjcf
ImportedArm readSdf(const std::string& text, const std::filesystem::path& file);

/// Kinds of robot files.
enum class RobotFormat { kArm, kMjcf, kUrdf, kSdf };

/// By a file's root element or, without XML, its first key. \throws DataError: none of them
RobotFormat robotFormatOf(const std::string& text, const std::filesystem::path& file);
/// By the name of a file that is to be written: .yaml, .xml or .mjcf, .urdf. \throws ConfigError: another
RobotFormat robotFormatOf(const std::filesystem::path& file);
std::string_view nameOf(RobotFormat format);

/// The arm as an MJCF model in radians, controlled by the shafts of its muscles [rad].
ExportedArm writeMjcf(const ArmModel& model);
/// Its bodies and joints as a URDF robot.
ExportedArm writeUrdf(const ArmModel& model);

}  // namespace simgap
