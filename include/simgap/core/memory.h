/// \file
/// What is said when the system grants no more memory.
#pragma once

namespace simgap {

inline constexpr const char* kNoMemory = "not enough memory: the input needs more than the system grants";

/// Where memory runs out while something is destroyed - nlohmann::json takes some there - nothing can be thrown. The
/// program then ends at once with kNoMemory and ExitCode::kUsage instead of a signal. Call once from main.
void installNoMemoryHandler();

}  // namespace simgap
