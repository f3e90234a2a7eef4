// The capture commands as a user runs them: the sample recording, and bad input.
#include <fmt/format.h>

#include "cli/capture_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST_F(CaptureTest, WritesAllItsTables) {
  succeed(capture({"--rate", "60", "--overlay", "1"}));
  for (const char* file : {"frames.csv", "joints.csv", "poses.csv", "markers.trc", "overlay_00001.png", "result.json",
                           "report.html", "run.json"}) {
    EXPECT_TRUE(fs::exists(path("out") / file)) << file;
  }
  const CsvTable joints = CsvTable::load(path("out/joints.csv"));
  ASSERT_EQ(joints.rows(), std::size_t(kPairs));
  const reality::ArmPose truth = reality::randomPose(1);
  EXPECT_NEAR(joints.quantity("elbow", "rad")[2], truth.elbow, 0.12 * kDegree);
  EXPECT_NEAR(joints.quantity("shoulder_qx", "")[2], truth.shoulder.x(), 0.12 * kDegree);
  EXPECT_EQ(CsvTable::load(path("out/frames.csv")).rows(), 3u * kPairs);
  EXPECT_EQ(countOf(text("out/markers.trc"), "\n"), 6u + kPairs);
  EXPECT_EQ(text("out/overlay_00001.png").substr(1, 3), "PNG");
  EXPECT_EQ(Json::parse(text("out/result.json")).at("geometry").at("verdict"), "consistent");
}

TEST_F(CaptureTest, APageOfALongRecordingShowsOneInSeveralPairs) {
  succeed(capture({"--rate", "60"}));
  const std::string whole = text("out/report.html");
  Json result = Json::parse(text("out/result.json"));
  result["pairs"] = 5'000;  // what decides how many of them are drawn: one in three
  put("out/result.json", toText(result));
  succeed({"report", "out"});
  const std::string thinned = text("out/report.html");
  EXPECT_THAT(thinned, HasSubstr("one in 3 pairs"));
  EXPECT_EQ(whole.find("one in "), std::string::npos);
  for (const char* moment : {"0.000 s", "0.050 s"}) EXPECT_THAT(thinned, HasSubstr(moment));
  EXPECT_THAT(whole, HasSubstr("0.017 s"));
  EXPECT_EQ(thinned.find("0.017 s"), std::string::npos);
}

TEST_F(CaptureTest, APageOfManyRestsShowsTheFirst) {
  succeed(capture({"--rate", "60", "--steady-duration", "0.03"}));
  Json result = Json::parse(text("out/result.json"));
  ASSERT_EQ(result.at("poses").size(), 1u);
  std::string table = text("out/poses.csv");
  const std::string row = table.substr(table.find('\n') + 1);
  for (int p = 1; p < 600; ++p) {
    table += replaced(row, "p000", fmt::format("p{:03}", p));
    result["poses"].push_back(result["poses"][0]);
    result["poses"].back()["pose"] = fmt::format("p{:03}", p);
  }
  put("out/poses.csv", table);
  put("out/result.json", toText(result));
  succeed({"report", "out"});
  const std::string page = text("out/report.html");
  EXPECT_THAT(page, HasSubstr("600 steady poses"));
  EXPECT_THAT(page, HasSubstr("The first 500 of 600 steady poses"));
  EXPECT_THAT(page, HasSubstr("p499"));
  EXPECT_EQ(page.find("p500"), std::string::npos);
}

TEST_F(CaptureTest, ReadsAVideo) {
  putVideo("left", kPairs, 60);
  putVideo("right", kPairs, 60);
  succeed({"capture", "rig.yaml", "--left", "left.y4m", "--right", "right.y4m", "--rate", "60", "-q", "-o", "video"});
  // Video players stretch grey values a little; the joints are the same within noise.
  succeed(capture({"--rate", "60"}));
  const auto elbow = [&](const char* file) { return CsvTable::load(path(file)).quantity("elbow", "rad")[1]; };
  EXPECT_NEAR(elbow("video/joints.csv"), elbow("out/joints.csv"), 0.1 * kDegree);
}

TEST_F(CaptureTest, FindsTheRestsOfTheSampleRecording) {
  const std::string sample = sourceFile("data/capture").string() + "/";
  succeed({"capture", sample + "rig.yaml", "--left", sample + "left", "--right", sample + "right", "--timestamps",
           sample + "timestamps.csv", "--shafts", sample + "shafts.csv", "-q", "-o", "out"});
  const CsvTable truth = CsvTable::load(sample + "truth.csv");
  const CsvTable joints = CsvTable::load(path("out/joints.csv"));
  const auto frame = joints.quantity("frame", "");
  const auto elbow = joints.quantity("elbow", "rad"), true_elbow = truth.quantity("elbow", "rad");
  double squares = 0.0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    squares += std::pow(elbow[i] - true_elbow[std::size_t(frame[i])], 2);
  }
  EXPECT_EQ(frame.size(), 60u);  // although two markers of the forearm cover one another in one of the six poses
  EXPECT_LT(std::sqrt(squares / double(frame.size())), 0.12 * kDegree);
  EXPECT_EQ(CsvTable::load(path("out/poses.csv")).rows(), 6u);
  EXPECT_NEAR(Json::parse(text("out/result.json")).at("shaft_lag_ms").get<double>(), 0.0, 20.0);
  // The chain of docs/capture.md goes on from there: the shafts belong to an arm that was measured as arm.yaml says.
  succeed({"calibrate", sourceFile("data/arm/arm.yaml").string(), "--poses", "out/poses.csv", "-q", "-o", "arm"});
  const Json errors = Json::parse(text("arm/result.json")).at("mje_deg").at("calibration");
  for (const char* joint : {"shoulder", "elbow"}) {
    EXPECT_GT(errors.at("initial").at(joint).get<double>(), 10.0) << joint;
    EXPECT_LT(errors.at("final").at(joint).get<double>(), 0.5) << joint;
  }
}

TEST_F(CaptureTest, RefusesImagesThatDoNotBelongTogether) {
  const Arguments rate = {"--rate", "60"};
  fs::remove(path("right") / name(3));
  expectRefused(capture(rate), 3, "found 4 left and 3 right images");
  fs::remove(path("left") / name(1));
  expectRefused(capture(rate), 3, "an image of one camera is missing");
  grey(path("right") / name(3), 640, 480, 8);
  grey(path("left") / name(1), 320, 240, 8);
  expectRefused(capture(rate), 3, "is 320x240 px");
}

TEST_F(CaptureTest, RefusesImagesOfOtherExposureOrSize) {
  grey(path("left") / name(0), 640, 480, 120);
  expectRefused(capture({"--rate", "60"}), 3, "expected the same exposure");
  grey(path("left") / name(0), 640, 480, 255);
  expectRefused(capture({"--rate", "60"}), 3, "overexposed");
  for (const char* side : {"left", "right"}) grey(path(side) / name(0), 320, 240, 8);
  expectRefused(capture({"--rate", "60"}), 3, "found 320x240 px, expected 640x480");
}

TEST_F(CaptureTest, NamesAnUnreadableImageAndSkipsItOnlyOnRequest) {
  put("left/" + name(2), "this is no image");
  expectRefused(capture({"--rate", "60"}), 3, name(2) + ": cannot be read as an image");
  succeed(capture({"--rate", "60", "--skip-unreadable"}));
  const CsvTable joints = CsvTable::load(path("out/joints.csv"));
  EXPECT_EQ(joints.quantity("frame", ""), (std::vector<double>{0, 1, 3}));
  EXPECT_EQ(Json::parse(text("out/result.json")).at("skipped").size(), 1u);
}

TEST_F(CaptureTest, RefusesWhatShowsNoTargets) {
  for (int i = 0; i < kPairs; ++i) {
    for (const char* side : {"left", "right"}) grey(path(side) / name(i), 640, 480, 8);
  }
  expectRefused(capture({"--rate", "60"}), 3, "found no target in 4 pairs (0.0 bright blobs per left image");
  fs::remove_all(path("left"));
  fs::create_directory(path("left"));
  expectRefused(capture({"--rate", "60"}), 3, "left: found no image");
  fs::remove_all(path("left"));
  expectRefused(capture({"--rate", "60"}), 2, "left: cannot be read");
}

TEST_F(CaptureTest, GoesOnWithoutATargetOnlyOnRequest) {
  put("targets.yaml", replaced(text("targets.yaml"), "[0.01", "[0.05"));  // a marker of the forearm, and …
  put("targets.yaml", replaced(text("targets.yaml"), "[-0.035", "[-0.09"));
  expectRefused(capture({"--rate", "60"}), 3, "never found the target forearm in 4 pairs");
  succeed(capture({"--rate", "60", "--partial"}));
  EXPECT_EQ(CsvTable::load(path("out/frames.csv")).rows(), 2u * kPairs);
}

TEST_F(CaptureTest, RefusesTimeThatDoesNotFit) {
  expectRefused(capture(), 2, "either --timestamps CSV or --rate HZ");
  put("t.csv", "frame,time_s\n0,0\n1,0.1\n2,0.2\n");
  expectRefused(capture({"--timestamps", "t.csv"}), 3, "more image pairs than the 3 time stamps");
  put("t.csv", "frame,time_s\n0,0\n1,0.1\n2,0.1\n3,0.2\n");
  expectRefused(capture({"--timestamps", "t.csv"}), 3, "t.csv:4: time does not increase");
  put("t.csv", "time_s\n0\n1\n2\n3\n4\n");
  expectRefused(capture({"--timestamps", "t.csv"}), 3, "found 5 time stamps for 4 image pairs");
  put("t.csv", "left_time_s,right_time_s\n0,0\n0.1,0.1\n0.2,0.215\n0.3,0.3\n");
  expectRefused(capture({"--timestamps", "t.csv"}), 3, "t.csv:4: the right camera is 15 ms behind the left one");
  put("t.csv", "left_time_s,right_time_s\n0,0.001\n0.1,0.101\n0.2,0.201\n0.3,0.301\n");
  succeed(capture({"--timestamps", "t.csv"}));
  EXPECT_NEAR(Json::parse(text("out/result.json")).at("camera_lag_ms").get<double>(), 1.0, 1e-6);
}

TEST_F(CaptureTest, RefusesABadRig) {
  const std::string rig = text("rig.yaml");
  const Arguments arguments = capture({"--rate", "60"});
  put("rig.yaml", replaced(rig, "simgap/rig/1", "simgap/rig/9"));
  expectRefused(arguments, 2, "expected simgap/rig/1");
  put("rig.yaml", replaced(rig, "[torso, 0]", "[torse, 0]"));
  expectRefused(arguments, 2, "found the target 'torse'");
  put("rig.yaml", replaced(rig, "[torso, 0]", "[torso, 7]"));
  expectRefused(arguments, 2, "rig.yaml:4");
  put("rig.yaml", rig + "spare: 1\n");
  expectRefused(arguments, 2, "spare");
  put("rig.yaml", rig);
  const std::string targets = text("targets.yaml");
  put("targets.yaml", replaced(targets, "[[0, -0.07", "[[0, -0.07, -0.1], [0, -0.07"));
  expectRefused(arguments, 2, "markers 0 and 1 are 0 mm apart");
  put("targets.yaml", replaced(targets, "name: humerus", "name: torso"));
  expectRefused(arguments, 2, "the target 'torso' stands twice");
}

TEST_F(CaptureTest, CalibrateCamerasRefusesAWrongBoard) {
  const Arguments board = {"calibrate-cameras", "left", "right", "--board", "chessboard:9x6:0.025", "-q", "-o", "out"};
  expectRefused(board, 3, "the board was seen by both cameras in 0 views");
  expectRefused({"calibrate-cameras", "left", "right", "--board", "chess:9x6:1", "-o", "out"}, 2, "--board: found");
  expectRefused({"calibrate-cameras", "left", "-o", "out"}, 2, "needs either LEFT RIGHT --board");
}

TEST_F(CaptureTest, TargetsCheckTellsSoundTargetsFromTwins) {
  EXPECT_EQ(simgap({"targets", "check", "targets.yaml", "-q", "-o", "sound"}).exit_code, 0);
  put("twins.yaml",
      "format: simgap/targets/1\nmarker_radius_m: 0.006\ntargets:\n"
      "  - {name: a, body: a, markers_m: [[0, 0, 0], [0.1, 0, 0], [0.02, 0.08, 0], [0.05, 0.02, 0.06]]}\n"
      "  - {name: b, body: b, markers_m: [[0, 0, 0.1], [0.1, 0, 0.1], [0.02, 0.08, 0.1], [0.05, 0.02, 0.16]]}\n");
  const ProcessResult result = simgap({"targets", "check", "twins.yaml", "-q", "-o", "twins"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, HasSubstr("CAN be confused"));
  expectRefused({"targets", "burn", "targets.yaml"}, 2, "ACTION");
}

TEST_F(CaptureTest, CalibrateJointsMakesARigThatCaptureTakes) {
  for (int i = 0; i < 24; ++i) put(i, {}, {reality::randomPose(std::uint64_t(i))});
  succeed(capture({"--rate", "60"}));
  succeed({"calibrate-joints", "rig.yaml", "--frames", "out/frames.csv", "-q", "-o", "joints"});
  EXPECT_NEAR(Json::parse(text("joints/result.json")).at("bones").at(0).at("length_mm").get<double>(), 280.0, 0.5);
  succeed({"capture", "joints/rig.yaml", "--left", "left", "--right", "right", "--rate", "60", "-q", "-o", "again"});
  const auto elbow = [&](const char* file) { return CsvTable::load(path(file)).quantity("elbow", "rad")[3]; };
  EXPECT_NEAR(elbow("again/joints.csv"), elbow("out/joints.csv"), 0.2 * kDegree);
  put("short.csv", firstLines(text("out/frames.csv"), 10));
  expectRefused({"calibrate-joints", "rig.yaml", "--frames", "short.csv", "-o", "o"}, 3, "expected at least 10");
}

}  // namespace
}  // namespace simgap::test
