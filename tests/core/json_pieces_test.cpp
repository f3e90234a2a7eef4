// JSON that does not fit in memory, written and read in pieces.
#include "simgap/core/json_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/files.h"

namespace simgap::test {
namespace {

Json element(std::size_t i) { return {{"name", "p\n" + std::to_string(i)}, {"values", {i, 0.1, nullptr}}, {"of", {}}}; }

Json objectWith(std::size_t elements) {
  Json object = {
      {"format", "test/1"}, {"list", Json::array()}, {"other", {{"list", {1, 2, 3}}}}, {"numbers", {7, 8, 9}}};
  for (std::size_t i = 0; i < elements; ++i) object["list"].push_back(element(i));
  return object;
}

std::string writtenInPieces(const Json& object, const LongList& list, std::size_t& largest_piece) {
  JsonPieces pieces(object, list);
  std::string text;
  for (std::string_view piece = pieces.next(); !piece.empty(); piece = pieces.next()) {
    text += piece;
    largest_piece = std::max(largest_piece, piece.size());
  }
  return text;
}

TEST(JsonPieces, AreTheTextOfTheWholeObjectAndNoneIsLong) {
  for (const std::size_t count : {0, 1, 2, 700, 30'000}) {
    std::size_t largest = 0;
    EXPECT_EQ(writtenInPieces(objectWith(0), {"list", count, element}, largest), toText(objectWith(count))) << count;
    EXPECT_LT(largest, 70'000u) << count;
  }
  std::size_t largest = 0;
  EXPECT_EQ(writtenInPieces(objectWith(3), {}, largest), toText(objectWith(3)));
}

TEST(JsonPieces, NoMoreOfAListIsReadThanIsWanted) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.put("result.json", toText(objectWith(10)));
  const auto readMost = [&](std::size_t most) {
    return readJson(file, [most](std::string_view format) {
      EXPECT_EQ(format, "test/1");
      return most;
    });
  };
  Json two = objectWith(2);
  two["numbers"] = {7, 8};
  EXPECT_EQ(readMost(2), two);  // the lists of the object, not those deeper down
  EXPECT_EQ(readMost(10), objectWith(10));
  EXPECT_EQ(readMost(kWholeList), objectWith(10));
  EXPECT_EQ(readJson(file), objectWith(10));
}

}  // namespace
}  // namespace simgap::test
