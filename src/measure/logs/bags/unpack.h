/// \file
/// Packed chunks of a recording.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace simgap::bags {

/// Memory grows with what is unpacked, not with what a file says.
/// \param size  bytes that have to come out. \throws Malformed: damaged, or of another size
std::string unpackLz4(std::string_view packed, std::uint64_t size);
std::string unpackZstd(std::string_view packed, std::uint64_t size);

}  // namespace simgap::bags
