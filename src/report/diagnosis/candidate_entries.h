/// \file
/// How the files of candidates are called.
#pragma once

#include <string>

namespace simgap {

/// "01-payload_forearm.yaml"
std::string candidateFileName(std::size_t number, const std::string& causes);

}  // namespace simgap
