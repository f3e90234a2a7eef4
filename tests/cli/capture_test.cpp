// The capture commands as a user runs them: the sample recording, bad input, and the whole chain from images of a known
// arm to a calibrated model.
#include "cli/cli_fixture.h"
#include "reality/arm_statics.h"
#include "reality/capture_arm.h"
#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A folder with the rig of the standard stage and a few rendered pairs.
class CaptureTest : public CliTest {
 protected:
  static constexpr int kPairs = 4;

  CaptureTest() {
    stage().writeRig(folder_.path());
    for (const char* side : {"left", "right"}) fs::create_directory(path(side));
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
  static void grey(const fs::path& file, int width, int height, int value) {
    reality::Image{width, height, std::vector<std::uint8_t>(std::size_t(width * height), std::uint8_t(value))}.writePgm(
        file);
  }
};

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

TEST_F(CaptureTest, ReadsAVideo) {
  putVideo("left", kPairs, 60);
  putVideo("right", kPairs, 60);
  succeed({"capture", "rig.yaml", "--left", "left.y4m", "--right", "right.y4m", "--rate", "60", "-q", "-o", "video"});
  // Video players stretch grey values a little; the joints are the same within noise.
  succeed(capture({"--rate", "60"}));
  const auto elbow = [&](const char* file) { return CsvTable::load(path(file)).quantity("elbow", "rad")[1]; };
  EXPECT_NEAR(elbow("video/joints.csv"), elbow("out/joints.csv"), 0.1 * kDegree);
}

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
  expectRefused(arguments, 2, "expected 'simgap/rig/1'");
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

// ----------------------------------------------------------------------------------------------- the whole chain

/// Renders an arm that stands in its equilibria (found from its energy alone), captures it, and calibrates a model
/// whose lines are wrong on the captured poses.
class ChainTest : public CaptureTest {
 protected:
  static constexpr int kPoses = 6;
  static constexpr int kFramesPerRest = 8;

  ChainTest() {
    for (const char* side : {"left", "right"}) {
      fs::remove_all(path(side));
      fs::create_directory(path(side));
    }
    put("rig.yaml",
        "format: simgap/rig/1\nstereo: stereo.yaml\ntargets: targets.yaml\njoints:\n"
        "  - {name: joint1, type: spherical, parent: torso, child: humerus}\n"
        "  - {name: joint2, type: revolute, parent: humerus, child: forearm, axis: [1, 0, 0]}\n");
    renderRests();
  }

  static bool inView(const reality::ArmPose& pose) {
    const reality::StereoLenses& lenses = stage().lenses();
    for (const auto& target : reality::markersInLeft(stage().targets(), pose)) {
      for (const Eigen::Vector3d& p : target) {
        const Eigen::Vector2d l = lenses.left.project(p);
        const Eigen::Vector2d r = lenses.right.project(lenses.rotation * p + lenses.translation);
        for (const Eigen::Vector2d& v : {l, r}) {
          if (v.x() < 10 || v.y() < 10 || v.x() > 630 || v.y() > 470) return false;
        }
      }
    }
    return true;
  }

  void renderRests() {
    const reality::Arm arm = reality::referenceArm();
    std::string shafts = "time_s";
    for (std::size_t m = 0; m < arm.muscles.size(); ++m) shafts += ",shaft_" + reality::muscleName(int(m)) + "_rad";
    shafts += "\n";
    int frame = 0;
    std::optional<reality::ArmPose> last;
    for (std::uint64_t seed = 1; poses_ < kPoses; ++seed) {
      const std::vector<double> angles = reality::randomShafts(arm, seed);
      const reality::Equilibrium rest = reality::followFromRest(arm, angles);
      const reality::ArmPose pose{Eigen::Quaterniond(rest.configuration[0].rotation), rest.configuration[1].angle};
      if (!rest.converged || !inView(pose)) continue;
      ++poses_;
      const int moving = last ? 3 : 0;
      for (int f = -moving; f < kFramesPerRest; ++f, ++frame) {
        put(frame, {0.0, 2}, {f < 0 ? reality::between(*last, pose, 1.0 + f / 4.0) : pose});
        shafts += std::to_string(frame / 60.0);
        for (const double angle : angles) shafts += "," + std::to_string(angle);
        shafts += "\n";
      }
      last = pose;
    }
    put("shafts.csv", shafts);
    put("true.yaml", reality::toYaml(arm, {.coulomb = false}));
    reality::Arm wrong = arm;
    for (std::size_t m = 0; m < wrong.muscles.size(); ++m) wrong.muscles[m].kite_line += m % 2 == 0 ? 0.006 : -0.006;
    put("wrong.yaml", reality::toYaml(wrong, {.coulomb = false}));
  }

  int poses_ = 0;
};

TEST_F(ChainTest, RenderCaptureCalibrateValidate) {
  // A patient protocol: without Coulomb friction the joints swing long.
  put("chain.yaml",
      "format: simgap/calibration/1\nparameters:\n  - {pattern: \"muscles.*.kite_line_length_m\", step: 3.0e-3}\n"
      "strategy: {mu: 3, lambda: 12, generations: 12, seed: 3}\n"
      "protocol: {step_s: 0.002, acquisition_s: 5, settle_s: 20, steady_s: 0.1, max_shaft_error_deg: 5, "
      "max_velocity_rad_s: 0.05, early_acquisition: true}\nevaluator: bullet\noptimizer: es\ncapture_sd_deg: 0.1\n");
  succeed(capture({"--rate", "60", "--shafts", "shafts.csv"}));
  ASSERT_EQ(CsvTable::load(path("out/poses.csv")).rows(), std::size_t(kPoses));
  const auto errors = [&](const std::string& model, const std::string& directory) {
    succeed({"validate", model, "--poses", "out/poses.csv", "--config", "chain.yaml", "-q", "-o", directory});
    const Json mje = Json::parse(text(directory + "/result.json")).at("mje_deg");
    return mje.at("joint1").get<double>() + mje.at("joint2").get<double>();
  };
  const double of_truth = errors("true.yaml", "v-true");
  const double before = errors("wrong.yaml", "v-wrong");
  succeed({"calibrate", "wrong.yaml", "--poses", "out/poses.csv", "--config", "chain.yaml", "-q", "-o", "calibrated"});
  const double after = errors("calibrated/model.yaml", "v-after");
  std::printf("joint errors, shoulder + elbow [deg]: true model %.2f, wrong model %.2f, calibrated %.2f\n", of_truth,
              before, after);
  // The true model rests where the cameras saw the arm: what is left is capture noise and the protocol's end speed.
  EXPECT_LT(of_truth, 1.0);
  EXPECT_GT(before, 5.0 * of_truth);
  EXPECT_LT(after, 0.8 * before);
}

}  // namespace
}  // namespace simgap::test
