/// \file
/// Where a command says what it does: stderr for people, log.txt for later.
#pragma once

#include <filesystem>

#include "simgap/cli/session.h"

namespace simgap {

/// stderr for people, `file` (none while it is empty) for later; stdout is for results only. A log that can no longer
/// be written is said once and does not end the run. \throws ConfigError when the file cannot be opened, or is a link:
/// it would be followed out of the directory.
void openLog(const CommonOptions& options, const std::filesystem::path& file = {});

}  // namespace simgap
