/// \file
/// Pieces of the texts in which a user names parameters and rows: "k_a=1.3", "k_v=0:5", "session=5,6".
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "simgap/core/error.h"

namespace simgap {

/// "NAME=VALUE", taken apart.
struct NamedText {
  std::string name, value;
};

/// \param option, expected  for the message. \throws ConfigError: one of the two is missing.
inline NamedText splitNamed(const std::string& option, const std::string& text, const char* expected) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    throw ConfigError(fmt::format("{}: found '{}', expected {}", option, text, expected));
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// The parts between separators; one part when there is none.
inline std::vector<std::string> splitText(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = 0; end != std::string::npos; begin = end + 1) {
    end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end == std::string::npos ? end : end - begin));
  }
  return parts;
}

}  // namespace simgap
