/// \file
/// Arm models as files: `format: simgap/arm/1` and `simgap/arm/2`.
#pragma once

#include <functional>
#include <string>

#include "simgap/core/yaml.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

using MeshReader = std::function<std::string(const std::string& file)>;

/// Reads an arm and checks it as a whole: names are unique and known, every moving body hangs on exactly one joint
/// whose chain ends at a fixed body, masses are positive.
/// \param mesh  reads the file of a part of `shape: mesh`, whose name is relative to the arm's; without one a mesh is
/// refused: a model stands in one file
/// \throws ConfigError with file, line and path.
ArmModel readArm(const YamlNode& root, const MeshReader& mesh = {});

/// The file that reads back as exactly the same model; of the first format where that can hold it.
std::string writeArm(const ArmModel& model);

}  // namespace simgap
