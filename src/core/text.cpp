#include "simgap/core/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace simgap {
namespace {

bool beginsCharacter(char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }

/// U+0080 to U+009F, which some terminals obey as they do ESC; in UTF-8 their first byte is 0xC2.
bool isUpperControl(std::string_view text, std::size_t at) {
  if (static_cast<unsigned char>(text[at]) != 0xC2U || at + 1 == text.size()) return false;
  const auto second = static_cast<unsigned char>(text[at + 1]);
  return second >= 0x80U && second <= 0x9FU;
}

/// Where the text of a line begins behind a short key and two blanks or more; where the line itself does, otherwise.
std::size_t textColumn(std::string_view line) {
  constexpr std::size_t kLongestKey = 24;
  const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
  const std::size_t gap = line.find("  ", indent);
  if (gap == std::string_view::npos || gap > indent + kLongestKey) return indent;
  const std::size_t begin = line.find_first_not_of(' ', gap);
  return begin == std::string_view::npos ? indent : begin;
}

std::string wrappedLine(std::string_view line, std::size_t width) {
  if (textWidth(line) <= width) return std::string(line);
  const std::size_t begin = textColumn(line);
  const std::string_view key = line.substr(0, begin);
  const bool keyed = key.find_first_not_of(' ') != std::string_view::npos;
  const std::size_t indent = keyed ? textWidth(key) : begin + 2;
  std::string text;
  for (const std::string& part : wordLines(line.substr(begin), width - std::min(indent, width / 2))) {
    text += text.empty() ? std::string(key) : "\n" + std::string(indent, ' ');
    text += part;
  }
  return text;
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
  while (head > 0 && !beginsCharacter(text[head])) --head;
  while (tail < text.size() && !beginsCharacter(text[tail])) ++tail;
  return std::string(text.substr(0, head)) + "…" + std::string(text.substr(tail));
}

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 20;
  std::string list;
  for (std::size_t i = 0; i < std::min(kMost, names.size()); ++i) list += (i > 0 ? ", " : "") + abridged(names[i]);
  return names.size() <= kMost ? list : fmt::format("{} and {} more", list, names.size() - kMost);
}

bool matchesGlob(std::string_view pattern, std::string_view text) {
  // Only the last `*` is ever tried again.
  std::size_t p = 0, t = 0, star = std::string_view::npos, behind_star = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      behind_star = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++behind_star;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

std::size_t textWidth(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, beginsCharacter));
}

std::string_view firstCharacters(std::string_view text, std::size_t characters) {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (beginsCharacter(text[i]) && seen++ == characters) return text.substr(0, i);
  }
  return text;
}

std::vector<std::string> wordLines(std::string_view text, std::size_t width) {
  std::vector<std::string> lines{""};
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (word.empty()) continue;
    std::string& line = lines.back();
    if (line.empty()) {
      line = word;
    } else if (textWidth(line) + 1 + textWidth(word) <= width) {
      line.append(1, ' ').append(word);
    } else {
      lines.emplace_back(word);
    }
  }
  return lines;
}

std::string shellWord(const std::string& text) {
  const auto safe = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || std::strchr("_-./+,:@", c); };
  if (!text.empty() && std::ranges::all_of(text, safe)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string wrapped(std::string_view text, std::size_t width) {
  std::string result;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    result += wrappedLine(text.substr(0, end), width);
    if (end < text.size()) result += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return result;
}

}  // namespace simgap
