#include "simgap/core/text.h"

#include <gtest/gtest.h>

namespace simgap {
namespace {

TEST(Text, ALongListSaysHowManyMoreThereAre) {
  EXPECT_EQ(listed({"a", "b"}), "a, b");
  std::vector<std::string> names(50000, "c");
  EXPECT_LT(listed(names).size(), 100U);
  EXPECT_TRUE(listed(names).ends_with("c and 49980 more"));
}

TEST(Text, PrintableHoldsNoControlCharacter) {
  EXPECT_EQ(printable("\x1b[2J\x07 a\tb\r\nc\x7f"), "?[2J? a b  c?");
  EXPECT_EQ(printable("a\nb\n", /*keep_lines=*/true), "a\nb\n");
  EXPECT_EQ(printable("caf\xc3\xa9 \xc2\x9b"
                      "31m \xc2\xb0"),
            "caf\xc3\xa9 ?31m \xc2\xb0");
  EXPECT_EQ(printable("\xc2"), "\xc2");
}

TEST(Text, AbridgedKeepsBothEndsAndWholeCharacters) {
  EXPECT_EQ(abridged("short", 5), "short");
  EXPECT_EQ(abridged("0123456789", 6), "0123…89");
  std::string degrees;
  for (int i = 0; i < 50; ++i) degrees += "°";
  for (std::size_t most = 1; most < 99; ++most) {
    const std::string cut = abridged(degrees, most);
    EXPECT_LE(cut.size(), most + 3);
    for (std::size_t at = 0; at < cut.size(); at += cut[at] == '\xe2' ? 3 : 2) {
      EXPECT_TRUE(cut.substr(at, 2) == "°" || cut.substr(at, 3) == "…") << most;
    }
  }
}

TEST(Text, IsAsWideAsItsCharacters) {
  EXPECT_EQ(textWidth(""), 0u);
  EXPECT_EQ(textWidth("a … °"), 5u);
  EXPECT_EQ(firstCharacters("α β", 2), "α ");
}

TEST(Text, BreaksBetweenWords) {
  EXPECT_EQ(wordLines("a bc def g", 4), (std::vector<std::string>{"a bc", "def", "g"}));
  EXPECT_EQ(wordLines("", 4), std::vector<std::string>{""});
  EXPECT_EQ(wordLines("unbreakable x", 4), (std::vector<std::string>{"unbreakable", "x"}));
}

TEST(Text, WhatContinuesALineStandsBelowItsText) {
  EXPECT_EQ(wrapped("short\n\nlines\n", 8), "short\n\nlines\n");
  EXPECT_EQ(wrapped("one two three", 9), "one two\n  three");
  EXPECT_EQ(wrapped("  one two three", 11), "  one two\n    three");
  EXPECT_EQ(wrapped("key   one two three", 14), "key   one two\n      three");
}

}  // namespace
}  // namespace simgap
