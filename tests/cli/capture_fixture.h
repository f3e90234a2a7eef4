/// \file
/// A rig with rendered images, for the capture commands.
#pragma once

#include "cli/cli_fixture.h"
#include "reality/arm_statics.h"
#include "reality/capture_arm.h"

namespace simgap::test {

/// A folder with the rig of the standard stage and a few rendered pairs.
class CaptureTest : public CliTest {
 protected:
  static constexpr int kPairs = 4;

  CaptureTest() {
    stage().writeRig(folder_.path());
    for (const char* side : {"left", "right"}) std::filesystem::create_directory(path(side));
    for (int i = 0; i < kPairs; ++i) put(i, {}, {reality::randomPose(std::uint64_t(1))});
  }
  using CliTest::put;

  static const reality::CaptureStage& stage() {
    static const reality::CaptureStage stage(reality::standardLenses(), reality::standardTargets());
    return stage;
  }
  static std::string name(int i) { return "img" + std::to_string(100 + i) + ".pgm"; }
  void put(int i, const reality::Disturbance& disturbance, const std::vector<reality::ArmPose>& poses) const {
    const reality::RenderedPair pair = stage().render(poses, disturbance, std::uint64_t(i));
    pair.left.writePgm(path("left") / name(i));
    pair.right.writePgm(path("right") / name(i));
  }
  Arguments capture(const Arguments& more = {}) const {
    Arguments all{"capture", "rig.yaml", "--left", "left", "--right", "right", "-q", "-o", "out"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// The images of one camera over and over, as a video of so many frames a second.
  void putVideo(const std::string& side, int frames, int rate) const {
    std::string video = "YUV4MPEG2 W640 H480 F" + std::to_string(rate) + ":1 Ip A1:1 Cmono\n";
    for (int i = 0; i < frames; ++i) {
      const std::string image = text(side + "/" + name(i % kPairs));
      video += "FRAME\n" + image.substr(image.size() - 640 * 480);
    }
    put(side + ".y4m", video);
  }
  static Arguments live(const Arguments& more = {}) {
    Arguments all{"capture", "rig.yaml", "--camera", "left.y4m,right.y4m", "-q", "-o", "out"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// An image of one grey value.
  static void grey(const std::filesystem::path& file, int width, int height, int value) {
    reality::Image{width, height, std::vector<std::uint8_t>(std::size_t(width * height), std::uint8_t(value))}.writePgm(
        file);
  }
};

}  // namespace simgap::test
