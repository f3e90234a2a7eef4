/// \file
/// Text taken from its front, piece by piece. Streams are no good for that: one that has no memory for a piece ends as
/// if the text did.
#pragma once

#include <algorithm>
#include <string_view>

namespace simgap {

/// Words between blanks and line ends.
class Words {
 public:
  explicit Words(std::string_view text) : left_(text) {}

  /// Empty at the end.
  std::string_view next() {
    constexpr std::string_view kBlanks = " \t\n\r\v\f";
    left_.remove_prefix(std::min(left_.find_first_not_of(kBlanks), left_.size()));
    const std::string_view word = left_.substr(0, left_.find_first_of(kBlanks));
    left_.remove_prefix(word.size());
    return word;
  }

 private:
  std::string_view left_;
};

/// Takes a line off the front of `text`, which is not empty; without its end.
inline std::string_view takeLine(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

}  // namespace simgap
