#include "simgap/core/text.h"

namespace simgap {
namespace {

bool continuesCharacter(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

/// U+0080 to U+009F, which some terminals obey as they do ESC; in UTF-8 their first byte is 0xC2.
bool isUpperControl(std::string_view text, std::size_t at) {
  if (static_cast<unsigned char>(text[at]) != 0xC2U || at + 1 == text.size()) return false;
  const auto second = static_cast<unsigned char>(text[at + 1]);
  return second >= 0x80U && second <= 0x9FU;
}

}  // namespace

std::string printable(std::string_view text, bool keep_lines) {
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char byte = text[at];
    const auto code = static_cast<unsigned char>(byte);
    if (byte == '\n' && keep_lines) {
      shown += byte;
    } else if (byte == '\n' || byte == '\r' || byte == '\t') {
      shown += ' ';
    } else if (code < 0x20U || code == 0x7FU) {
      shown += '?';
    } else if (isUpperControl(text, at)) {
      shown += '?';
      ++at;
    } else {
      shown += byte;
    }
  }
  return shown;
}

std::string abridged(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  std::size_t head = 2 * most / 3, tail = text.size() - most / 3;
  while (head > 0 && continuesCharacter(text[head])) --head;
  while (tail < text.size() && continuesCharacter(text[tail])) ++tail;
  return std::string(text.substr(0, head)) + "…" + std::string(text.substr(tail));
}

}  // namespace simgap
