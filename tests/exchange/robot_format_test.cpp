// What a file is by its text and, where that says nothing, by its ending.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simgap/exchange/exchange.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

TEST(RobotFormat, IsThatOfTheOutermostElement) {
  EXPECT_EQ(robotFormatOf("<!-- <sdf> -->\n<mujoco/>", "a.xml"), RobotFormat::kMjcf);
  EXPECT_EQ(robotFormatOf("\xEF\xBB\xBF<robot/>", "a.xml"), RobotFormat::kUrdf);
  EXPECT_EQ(robotFormatOf("<?xml version='1.0'?><sdf/>", "a.txt"), RobotFormat::kSdf);
  EXPECT_EQ(robotFormatOf("format: simgap/arm/1", "a.yaml"), RobotFormat::kArm);
}

TEST(RobotFormat, AFileThatIsNoneSaysWhatItIs) {
  const auto refused = [](const std::string& text, const std::string& file) {
    return errorOf([&] { robotFormatOf(text, file); });
  };
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:abc\nsize 123\n";
  EXPECT_THAT(refused(pointer, "a.xml"), HasSubstr("a.xml: found a pointer of Git LFS"));
  EXPECT_THAT(refused(pointer, "a.yaml"), HasSubstr("a pointer of Git LFS"));
  EXPECT_THAT(refused("", "a.urdf"), HasSubstr("a.urdf: found an empty file, expected a robot in XML"));
  EXPECT_THAT(refused(" \n", "a.sdf"), HasSubstr("found an empty file"));
  EXPECT_THAT(refused(std::string("\xFF\xFE<\0m\0", 6), "a.xml"), HasSubstr("found UTF-16 text"));
  EXPECT_THAT(refused(std::string("<\0m\0", 4), "a.xml"), HasSubstr("found UTF-16 text"));
  EXPECT_THAT(refused(std::string(84, '\0'), "a.xml"), HasSubstr("found no text, expected")) << "a binary STL";
  EXPECT_THAT(refused("format: simgap/arm/1", "a.xml"), HasSubstr("found no XML"));
}

}  // namespace
}  // namespace simgap::test
