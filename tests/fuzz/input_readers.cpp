#include <algorithm>
#include <array>

#include "core/csv_cells.h"
#include "fuzz/readers.h"
#include "simgap/capture/board.h"
#include "simgap/capture/camera_files.h"
#include "simgap/capture/image_pairs.h"
#include "simgap/capture/joint_calibration.h"
#include "simgap/capture/marker_targets.h"
#include "simgap/capture/steady_poses.h"
#include "simgap/capture/stereo_cameras.h"
#include "simgap/core/error.h"
#include "simgap/exchange/exchange.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/measure/logs/bag.h"
#include "simgap/measure/logs/bench.h"
#include "simgap/measure/logs/log_table.h"
#include "simgap/measure/logs/spring_log.h"
#include "simgap/measure/motion_set.h"
#include "simgap/measure/pose_set.h"
#include "simgap/model/actuator/fitted_model.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/solids/mesh.h"

namespace simgap::test {
namespace {

YamlNode yaml(const std::string& bytes) { return YamlNode::parse(bytes, "input.yaml"); }

/// A table, and everything that can be asked of it.
void readTable(std::string bytes) {
  for (const bool skip : {false, true}) {
    CsvOptions options;
    options.skip_bad_rows = skip;
    const CsvTable table = CsvTable::parse(bytes, "input.csv", options);
    for (const std::string& column : table.columns()) {
      table.text(column);
      table.badRows(column);
      const UnitName name = splitUnit(column);
      if (table.isNumeric(column) && table.offersQuantity(name.stem, name.unit)) table.quantity(name.stem, name.unit);
    }
  }
}

void readPacked(std::string bytes) { unpackCsv(std::move(bytes), "input.csv.gz", std::size_t{1} << 20U); }

PoseLayout layoutOfTwo() {
  PoseLayout layout;
  layout.muscles = {"a", "b"};
  layout.joints = {{"s", JointType::kSpherical}, {"e", JointType::kRevolute}};
  return layout;
}

void readPoses(std::string bytes) { readPoseSet(CsvTable::parse(std::move(bytes), "input.csv"), layoutOfTwo()); }

/// A set of motions whose tables are what the fuzzer made, too: behind a line "---" that of the muscles, behind the
/// next one that of the joints.
void readMotions(std::string bytes) {
  std::array<std::string, 3> parts;
  std::string_view left = bytes;
  for (std::string& part : parts) {
    const std::size_t end = std::min(left.find("\n---\n"), left.size());
    part = left.substr(0, end);
    left.remove_prefix(std::min(end + 5, left.size()));
  }
  readMotionSet(yaml(parts[0]), "input.yaml", layoutOfTwo(), [&](const std::filesystem::path& file) {
    const bool of_joints = file.string().find("joints") != std::string::npos;
    return CsvTable::parse(parts[of_joints ? 2 : 1], file.string());
  });
}

/// A log of any kind: each reader takes the columns it knows.
void readLog(std::string bytes) {
  const LogTable log = readLogTable(CsvTable::parse(std::move(bytes), "input.csv"));
  const auto tryReading = [&](auto&& read) {
    try {
      read(log.table);
    } catch (const DataError&) {
    }
  };
  tryReading([](const CsvTable& table) { readActuatorLog(table, {}); });
  tryReading([](const CsvTable& table) { readMotorLog(table); });
  tryReading([](const CsvTable& table) { readPamLog(table); });
  tryReading([](const CsvTable& table) { readSignedSpringLog(table); });
}

/// A recording, and every number of it.
void readRecording(std::string bytes) {
  const std::vector<std::string> topics = readableTopics(bytes, "input.mcap");
  readBag(std::move(bytes), "input.mcap", topics);
}

void readBoardCorners(std::string bytes) { readCorners(CsvTable::parse(std::move(bytes), "input.csv")); }
void readFitted(std::string bytes) { readFittedModel(yaml(bytes)); }
void readBenchOf(std::string bytes) { readBench(yaml(bytes)); }
/// What was read is written in the other formats, too.
void writeRobot(const ArmModel& model) {
  writeMjcf(model);
  writeUrdf(model);
}
void readArmModel(std::string bytes) { writeRobot(readArm(yaml(bytes))); }
/// No file is there to include.
void readMjcfRobot(std::string bytes) {
  const auto none = [](const std::filesystem::path& file) -> std::string {
    throw DataError(file.string() + ": is not there");
  };
  writeRobot(readMjcf(bytes, "input.xml", none).model);
}
void readUrdfRobot(std::string bytes) { writeRobot(readUrdf(bytes, "input.urdf").model); }
void readSdfRobot(std::string bytes) { writeRobot(readSdf(bytes, "input.sdf").model); }
/// A mesh of the kind that its first bytes suggest; otherwise it comes by the file's name.
void readSolid(std::string bytes) {
  const bool stl = bytes.starts_with("solid") || bytes.find('\0') != std::string::npos;
  const char* const name = stl ? "input.stl" : "input.obj";
  volumeOf(readMesh(bytes, name), name).inertia(1.0);
}
void readTargetSet(std::string bytes) { readTargets(yaml(bytes)); }
/// A file of both cameras, or the same camera_info for each.
void readCamerasOf(std::string bytes) {
  try {
    readCameras(std::vector<CameraFile>{{"left.yaml", bytes}, {"right.yaml", bytes}});
  } catch (const Error&) {
  }
  readCameras(std::vector<CameraFile>{{"input.yaml", bytes}});
}

TargetSet targetsOfTwo() {
  TargetSet targets;
  targets.marker_radius = 0.006;
  for (const char* name : {"torso", "humerus"}) {
    targets.targets.push_back({name, name, {{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.2, 0.0}, {0.0, 0.0, 0.3}}});
  }
  return targets;
}
void readStereoRig(std::string bytes) {
  rigFiles(yaml(bytes));
  readRig(yaml(bytes), targetsOfTwo());
}

/// The tables beside images: of the cameras' clocks, of the shafts, of what a capture found.
void readCaptureTables(std::string bytes) {
  const CsvTable table = CsvTable::parse(std::move(bytes), "input.csv");
  const auto tryReading = [&](auto&& read) {
    try {
      read();
    } catch (const Error&) {
    }
  };
  tryReading([&] { readTimes(table, 0.02); });
  tryReading([&] { readShaftLog(table); });
  readMotion(table, targetsOfTwo());
}

constexpr std::array kReaders = {
    Reader{"csv", readTable},         Reader{"gzip", readPacked},           Reader{"poses", readPoses},
    Reader{"log", readLog},           Reader{"corners", readBoardCorners},  Reader{"arm", readArmModel},
    Reader{"fitted", readFitted},     Reader{"bench", readBenchOf},         Reader{"targets", readTargetSet},
    Reader{"rig", readStereoRig},     Reader{"cameras", readCamerasOf},     Reader{"mcap", readRecording},
    Reader{"rosbag2", readRecording}, Reader{"mjcf", readMjcfRobot},        Reader{"urdf", readUrdfRobot},
    Reader{"motions", readMotions},   Reader{"capture", readCaptureTables}, Reader{"sdf", readSdfRobot},
    Reader{"mesh", readSolid},
};

}  // namespace

std::span<const Reader> inputReaders() { return kReaders; }

}  // namespace simgap::test
