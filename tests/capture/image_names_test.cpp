// The order of the images of a folder, and what it takes to know their names.
#include "capture/image_names.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string.h>

#include <algorithm>

#include "simgap/core/error.h"
#include "support/files.h"

namespace simgap::test {
namespace {

/// Of a folder of these files.
ImageNames namesOf(const std::vector<std::string>& files) {
  const TemporaryFolder folder;
  for (const std::string& file : files) folder.put(file, "");
  return ImageNames(folder.path());
}

std::vector<std::string> allOf(const ImageNames& names) {
  std::vector<std::string> all;
  for (std::size_t i = 0; i < names.size(); ++i) all.push_back(names.at(i));
  return all;
}

std::vector<std::string> asPeopleCount(std::vector<std::string> files) {
  std::ranges::sort(files, [](const auto& a, const auto& b) { return strverscmp(a.c_str(), b.c_str()) < 0; });
  return files;
}

TEST(ImageNames, NumbersWithoutAGapTakeNoMemory) {
  for (const int digits : {1, 2, 3, 6}) {  // with zeros in front; more digits behind the largest number of so many
    std::vector<std::string> files;
    for (int i = 5; i < 1205; ++i) files.push_back(fmt::format("cam2_{:0{}}_l.png", i, digits));
    const ImageNames names = namesOf(files);
    EXPECT_FALSE(names.listed()) << digits;
    EXPECT_EQ(allOf(names), asPeopleCount(files)) << digits;
  }
}

TEST(ImageNames, OthersAreSortedAsPeopleCount) {
  const std::vector<std::vector<std::string>> folders = {
      {"1.png", "2.png", "4.png"},                // a gap
      {"01.png", "02.png", "3.png"},              // not one way
      {"001.png", "02.png", "03.png"},            // nor these
      {"1.png", "2.PNG", "3.png"},                // two endings
      {"a1.png", "b2.png", "b3.png"},             // two texts
      {"9.png", "10.png", "11.png", "left.png"},  // one without a number
      {"1.png", "99999999999999999999.png"}};     // one too large
  for (const std::vector<std::string>& files : folders) {
    const ImageNames names = namesOf(files);
    EXPECT_TRUE(names.listed()) << files.front();
    EXPECT_EQ(allOf(names), asPeopleCount(files)) << files.front();
  }
  EXPECT_EQ(allOf(namesOf({"10.png", "9.png", "left.txt"})), (std::vector<std::string>{"9.png", "10.png"}));
}

TEST(ImageNames, AFolderWithoutImagesIsRefused) { EXPECT_THROW(namesOf({"left.txt"}), DataError); }

}  // namespace
}  // namespace simgap::test
