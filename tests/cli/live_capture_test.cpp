// capture --camera: images that come while they are looked at.
#include "cli/capture_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Of a live result: frames that came are used, dropped, without partner, or still waited at the end.
void expectAllCounted(const Json& result, std::size_t most_waiting) {
  const Json& live = result.at("live");
  for (std::size_t side = 0; side < 2; ++side) {
    const std::size_t came = live.at("frames")[side];
    const std::size_t known = result.at("pairs").get<std::size_t>() + live.at("dropped")[side].get<std::size_t>() +
                              live.at("unpaired")[side].get<std::size_t>();
    EXPECT_LE(known, came + most_waiting) << side;  // a frame may drop out while it is paired
    EXPECT_LE(came, known + most_waiting) << side;
  }
}

TEST_F(CaptureTest, CamerasThatRunAreFollowedInRealTime) {
  constexpr int kFrames = 30, kRate = 20;
  putVideo("left", kFrames, kRate);
  putVideo("right", kFrames, kRate);
  const std::string printed = succeed(live());
  const Json result = Json::parse(text("out/result.json"));
  const Json& figures = result.at("live");
  EXPECT_GE(figures.at("seconds").get<double>(), (kFrames - 1.0) / kRate);  // not faster than they were taken
  EXPECT_EQ(figures.at("frames"), Json({kFrames, kFrames}));
  expectAllCounted(result, 3);
  // A pair takes milliseconds: on any machine most are on time.
  EXPECT_GT(result.at("pairs_with_all_joints").get<int>(), kFrames / 2);
  EXPECT_GT(figures.at("latency_ms").at("median").get<double>(), 0.0);
  EXPECT_LT(figures.at("latency_ms").at("median").get<double>(), 150.0);
  EXPECT_THAT(printed, HasSubstr("pairs and poses a second"));
  // Time counts from the first image on; the arm stands still, which is one rest.
  const auto times = CsvTable::load(path("out/joints.csv")).quantity("time", "s");
  EXPECT_NEAR(times.back() - times.front(), (kFrames - 1.0) / kRate, 0.5);
  EXPECT_EQ(CsvTable::load(path("out/poses.csv")).rows(), 1u);
  EXPECT_NEAR(CsvTable::load(path("out/joints.csv")).quantity("elbow", "rad")[1], reality::randomPose(1).elbow,
              0.2 * kDegree);
}

TEST_F(CaptureTest, CamerasOfUnequalClocksPairTheirNearestFrames) {
  putVideo("left", 40, 20);
  putVideo("right", 20, 10);  // every other left frame has no partner
  succeed(live());
  const Json result = Json::parse(text("out/result.json"));
  expectAllCounted(result, 3);
  const std::size_t pairs = result.at("pairs");
  EXPECT_LE(pairs, 21u);
  EXPECT_GE(pairs, 10u);
  EXPECT_GE(result.at("live").at("unpaired")[0].get<int>() + result.at("live").at("dropped")[0].get<int>(), 15);
}

TEST_F(CaptureTest, LiveRunsEndByDurationOrCtrlCWithACompleteResult) {
  putVideo("left", 200, 20);
  putVideo("right", 200, 20);
  succeed(live({"--duration-s", "1"}));
  const double seconds = Json::parse(text("out/result.json")).at("live").at("seconds");
  EXPECT_GE(seconds, 1.0);
  EXPECT_LT(seconds, 5.0);  // of 10
  Arguments interrupted{"/usr/bin/timeout", "--preserve-status", "-s", "INT", "3"};
  for (const std::string& argument : command(live({"--force"}))) interrupted.push_back(argument);
  const ProcessResult ended = runProcess(interrupted, folder_.path());
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(Json::parse(text("out/run.json")).at("status"), "done");
  EXPECT_LT(Json::parse(text("out/result.json")).at("live").at("seconds").get<double>(), 9.0);
  EXPECT_GT(CsvTable::load(path("out/joints.csv")).rows(), 1u);
  EXPECT_TRUE(fs::exists(path("out/report.html")));
}

TEST_F(CaptureTest, RefusesCamerasThatAreNone) {
  allowLeaks();  // libusb's, when a camera is refused
  putVideo("left", 2, 20);
  const auto camera = [](const std::string& names, const Arguments& more = {}) {
    Arguments all{"capture", "rig.yaml", "--camera", names, "-q", "-o", "out"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  expectRefused(camera("left.y4m"), 2, "--camera: found 'left.y4m', expected LEFT,RIGHT");
  expectRefused(camera("left.y4m,977"), 2, "/dev/video977: found no camera or video");
  expectRefused(camera("left.y4m,rig.yaml"), 3, "rig.yaml: cannot be opened as a camera or a video");
  expectRefused(camera("left.y4m,left.y4m", {"--shafts", "s.csv"}), 2, "found --shafts with --camera");
  expectRefused(capture({"--rate", "60", "--duration-s", "1"}), 2, "found --duration-s without --camera");
  expectRefused({"capture", "rig.yaml", "--rate", "60", "-q", "-o", "out"}, 2,
                "either --left and --right, or --camera");
}

}  // namespace
}  // namespace simgap::test
