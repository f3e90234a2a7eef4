/// \file
/// What a diagnosis of poses left in its folder of candidates.
#pragma once

#include <filesystem>

#include "simgap/cli/session.h"
#include "simgap/intervene/poses/pose_intervention.h"

namespace simgap {

/// \throws ConfigError: files in the folder that are none; DataError: a pose that the list names is missing.
PoseEvidence readPoseEvidence(const std::filesystem::path& run, Session& session);

}  // namespace simgap
