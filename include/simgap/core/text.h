/// \file
/// Text out of files as a message or a terminal may show it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace simgap {

/// Without control characters, so that no name in a file moves the cursor, sets a title or paints a line that was never
/// written: '?' stands for each, a blank for tabs and, unless `keep_lines`, for line ends. What is no UTF-8 stays.
std::string printable(std::string_view text, bool keep_lines = false);

/// At most about `most` bytes: the beginning, "…" and the end. No character of UTF-8 is cut.
std::string abridged(std::string_view text, std::size_t most = 80);

}  // namespace simgap
