/// \file
/// Words that MuJoCo knows where an attribute takes one of a few.
#pragma once

#include <span>
#include <string_view>

namespace simgap {

/// What the attribute of an element may say; empty: it is no keyword.
std::span<const std::string_view> mjcfKeywords(std::string_view tag, std::string_view attribute);

}  // namespace simgap
