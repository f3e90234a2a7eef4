// Files of other programs as a user hands them over: recordings instead of logs, cameras of Kalibr, ROS and OpenCV.
#include <cmath>

#include "cli/cli_fixture.h"
#include "simgap/capture/camera_files.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"
#include "support/bags.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

class NeighboursTest : public CliTest {
 protected:
  static std::string sample(const std::string& name) { return sourceFile("data/" + name).string(); }

  static Arguments withTopics(Arguments command) {
    const Arguments topics = {"--topic", "/joint_states:bend",
                              "--topic", "/motor/current",
                              "--topic", "/load/torque",
                              "--map",   "motor_velocity_rad_s=bend.velocity",
                              "--map",   "motor_current_A=motor/current",
                              "--map",   "external_torque_Nm=load/torque"};
    command.insert(command.end(), topics.begin(), topics.end());
    return command;
  }
  Json parametersOf(const std::string& directory) const {
    return Json::parse(text(directory + "/result.json")).at("parameters");
  }
};

/// The sample recording was made of the first rows of a sample log.
TEST_F(NeighboursTest, ARecordingIsFittedAsTheLogItWasMadeOf) {
  const CsvTable table = CsvTable::load(sample("logs/bend-friction.csv.gz"));
  const auto column = [&](const char* stem, const char* unit) { return table.quantity(stem, unit); };
  const auto time = column("time", "s"), current = column("motor_current", "A"),
             speed = column("motor_velocity", "rad_s"), torque = column("external_torque", "Nm");
  CsvWriter csv({"time_s", "motor_current_A", "motor_velocity_rad_s", "external_torque_Nm"});
  for (std::size_t i = 0; i < 3000; ++i)
    csv.add(time[i] - time[0]).add(current[i]).add(speed[i]).add(torque[i]).endRow();
  put("log.csv", csv.text());
  succeed({"fit-friction", "log.csv", "--model", "classic", "-q", "-o", "csv"});
  succeed(withTopics({"fit-friction", sample("logs/bend.mcap"), "--model", "classic", "-q", "-o", "mcap"}));
  const Json of_log = parametersOf("csv"), of_recording = parametersOf("mcap");
  ASSERT_EQ(of_log.size(), of_recording.size());
  for (std::size_t i = 0; i < of_log.size(); ++i) {
    const double value = of_log[i].at("value").get<double>();
    EXPECT_NEAR(of_recording[i].at("value").get<double>(), value, 1e-6 * std::abs(value)) << of_log[i].at("name");
  }
}

TEST_F(NeighboursTest, EveryCommandThatReadsALogTakesARecording) {
  const std::string bag = sample("logs/bend.mcap");
  put("run.db3", rosbag2Bytes(smallRecording()));
  succeed(withTopics({"fit-friction", bag, "--model", "classic", "-q", "-o", "fit"}));
  succeed(withTopics({"predict", "fit/model.yaml", bag, "-q", "-o", "prediction"}));
  EXPECT_GT(CsvTable::load(path("prediction/prediction.csv")).rows(), 2900u);
  succeed(withTopics({"diagnose", "classic", "--log", bag, "--dry-run"}));
  EXPECT_THAT(succeed({"fit-motor", "run.db3", "--topic", "/joint_states", "--topic", "/motor/current", "--map",
                       "velocity_rad_s=elbow.velocity", "--map", "current_A=motor/current", "--dry-run"}),
              HasSubstr("to 5 rows of run.db3"));
  // Topics that are called like channels need no --map.
  std::vector<RecordedMessage> cord;
  for (int i = 0; i < 300; ++i) {
    const double x = 0.05 + 0.03 * std::sin(0.1 * i);
    const std::int64_t time = 1'000'000'000 + 50'000'000 * std::int64_t{i};
    const auto put_message = [&](const std::string& topic, double value) {
      cord.push_back({topic, "std_msgs/Float64", "ros1", time, float64(Wire::kRos1, value)});
    };
    put_message("/deflection_m", x);
    put_message("/force_N", 150.0 * x + 0.01 * std::sin(7.0 * i));
  }
  put("cord.mcap", mcapBytes(cord, {.compression = "lz4", .messages_per_chunk = 100}));
  succeed({"fit-spring", "cord.mcap", "--topic", "/deflection_m", "--topic", "/force_N", "-q", "-o", "cord"});
  EXPECT_NEAR(parametersOf("cord")[0].at("value").get<double>(), 150.0, 0.5);
}

TEST_F(NeighboursTest, SaysWhichTopicsThereAre) {
  put("run.db3", rosbag2Bytes(smallRecording()));
  put("log.csv", "time_s,force_N\n0,1\n");
  expectRefused({"fit-spring", "run.db3"}, 2, "found a recording and no --topic");
  expectRefused({"fit-spring", "run.db3", "--topic", "/joint_sates"}, 3, "did you mean /joint_states?");
  expectRefused({"fit-spring", "log.csv", "--topic", "/a"}, 2, "log.csv: found --topic, expected it with a recording");
  expectRefused({"diagnose", "arm.yaml", "--poses", "poses.csv", "--topic", "/a"}, 2, "expected it with --log");
}

TEST_F(NeighboursTest, CaptureTakesTheCamerasOfOtherPrograms) {
  const std::string yaml = readText(sample("capture/stereo.yaml"));
  const StereoCameras cameras = readStereo(yaml, "stereo.yaml");
  put("camchain.yaml", writeCamchain(cameras).value());
  put("left.yaml", writeCameraInfo(cameras).value()[0]);
  put("right.yaml", writeCameraInfo(cameras).value()[1]);
  put("stereo.xml", writeStereoXml(cameras));
  const auto capture = [&](const std::string& output, const Arguments& more) {
    Arguments all{"capture", sample("capture/rig.yaml"),
                  "--left",  sample("capture/left"),
                  "--right", sample("capture/right"),
                  "--rate",  "60",
                  "-q",      "-o",
                  output};
    all.insert(all.end(), more.begin(), more.end());
    succeed(all);
    return CsvTable::load(path(output + "/joints.csv")).quantity("elbow", "rad");
  };
  const std::vector<double> truth = capture("own", {});
  for (const Arguments& given :
       {Arguments{"--cameras", "camchain.yaml"}, Arguments{"--cameras", "left.yaml", "right.yaml"},
        Arguments{"--cameras", "stereo.xml"}}) {
    SCOPED_TRACE(given[1]);
    EXPECT_THAT(capture(given[1] + ".run", given), testing::Pointwise(testing::DoubleNear(1e-6), truth));
  }
  succeed({"calibrate-joints", sample("capture/rig.yaml"), "--frames", "own/frames.csv", "--cameras", "camchain.yaml",
           "--zero", "0:10", "-q", "-o", "joints"});
  EXPECT_EQ(readStereo(text("joints/stereo.yaml"), "stereo.yaml").left.K, cameras.left.K);
}

TEST_F(NeighboursTest, CalibrateCamerasWritesThemForOtherPrograms) {
  succeed({"calibrate-cameras", sample("boards/left"), sample("boards/right"), "--board", "chessboard:9x6:0.025",
           "--distortion", "4", "-q", "-o", "four"});
  const StereoCameras own = readStereo(text("four/stereo.yaml"), "stereo.yaml");
  const std::vector<std::vector<std::string>> written = {
      {"camchain.yaml"}, {"stereo.xml"}, {"left_camera_info.yaml", "right_camera_info.yaml"}};
  for (const std::vector<std::string>& names : written) {
    std::vector<CameraFile> files;
    for (const std::string& name : names) files.push_back({name, text("four/" + name)});
    const StereoCameras again = readCameras(files);
    EXPECT_EQ(again.left.K, own.left.K) << names[0];
    EXPECT_EQ(again.size, own.size) << names[0];
    EXPECT_LT((again.translation - own.translation).norm(), 1e-12) << names[0];
    EXPECT_LT((again.rotation - own.rotation).norm(), 1e-12) << names[0];
  }
}

}  // namespace
}  // namespace simgap::test
