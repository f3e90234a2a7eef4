#include "simgap/core/text.h"

#include <gtest/gtest.h>

namespace simgap {
namespace {

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
