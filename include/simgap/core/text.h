/// \file
/// Text as a message or a terminal shows it: without control characters, how wide it is, and where its lines break.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace simgap {

/// Without control characters, so that no name in a file moves the cursor, sets a title or paints a line that was never
/// written: '?' stands for each, a blank for tabs and, unless `keep_lines`, for line ends. What is no UTF-8 stays.
std::string printable(std::string_view text, bool keep_lines = false);

/// At most about `most` bytes: the beginning, "…" and the end. No character of UTF-8 is cut.
std::string abridged(std::string_view text, std::size_t most = 80);

/// "a, b, c": what a file holds instead of what was looked for. After the first twenty, how many more there are.
std::string listed(const std::vector<std::string>& names);

/// True when the text is the pattern's, in which `*` stands for any text. Quadratic at worst.
bool matchesGlob(std::string_view pattern, std::string_view text);

/// Columns of what is printed: tables, sentences, help.
inline constexpr std::size_t kTextWidth = 80;

/// Columns that a UTF-8 text takes, one per character.
std::size_t textWidth(std::string_view text);

/// The first `characters` of a UTF-8 text, not cut inside a character.
std::string_view firstCharacters(std::string_view text, std::size_t characters);

/// The words of a text in lines of at most `width` columns; a word that is longer stands alone. One line for no words.
std::vector<std::string> wordLines(std::string_view text, std::size_t width);

/// A text as a shell takes it for one word.
std::string shellWord(const std::string& text);

/// Breaks the lines of a text that are wider than `width` between words; the others stay as they are. What continues a
/// line stands below its text: behind its indentation and its key ("gap       RMS …"), or two columns further.
std::string wrapped(std::string_view text, std::size_t width = kTextWidth);

}  // namespace simgap
