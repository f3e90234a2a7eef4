/// \file
/// Parts of the program that are loaded on first use, because the libraries they bring along cost time and memory at
/// every start.
#pragma once

#include <string>

namespace simgap {

/// Loads a module: lib/simgap/libsimgap_NAME.so beside the installed program, or where it was built, for a program that
/// itself stands in that build's folder. Another program never looks there: anybody may have made a folder of that
/// name. \param entry  its function that returns what it offers, `extern "C"`.  \returns that function's address.
/// \throws ConfigError when it cannot be loaded.
void* moduleEntry(const std::string& name, const char* entry);

}  // namespace simgap
