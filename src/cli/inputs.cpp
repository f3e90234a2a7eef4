#include "inputs.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "simgap/core/error.h"
#include "simgap/measure/logs/bag.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/html/assets.h"
#include "simgap/simulate/replay.h"

namespace simgap {
namespace {

void warnOfSkippedRows(const CsvTable& table) {
  if (table.skippedRows() > 0) spdlog::warn("{}: {} bad rows left out", table.name(), table.skippedRows());
}

LogTable readLogOf(CsvTable table, const std::vector<std::string>& sessions) {
  warnOfSkippedRows(table);
  return readLogTable(std::move(table), sessions);
}

}  // namespace

ArmModel readArmFile(Session& session, const std::string& role, const std::string& file) {
  return readArm(YamlNode::parse(session.read(role, file).content, file));
}

CalibrationConfig readConfig(Session& session, const std::string& file, const ArmModel* model) {
  const std::string name = file.empty() ? "configs/calibrate_arm.yaml" : file;
  const std::string text =
      file.empty() ? std::string(assets::calibrate_arm_yaml()) : session.read("config", file).content;
  const CalibrationConfig config = CalibrationConfig::read(YamlNode::parse(text, name));
  try {
    if (model != nullptr) ParameterSpace(*model, config.parameters);
  } catch (const ConfigError& error) {
    throw ConfigError(
        fmt::format("{}: {}{}", name, error.what(),
                    file.empty() ? " (these parameters are the built-in ones; --config FILE gives others)" : ""));
  }
  return config;
}

PoseSet readPoses(Session& session, const std::string& role, const std::string& file, const ArmModel& model,
                  const CsvOptions& csv) {
  const CsvTable table = CsvTable::parse(session.read(role, file).content, file, csv);
  warnOfSkippedRows(table);
  return readPosesFor(model, table);
}

PoseSet readPoses(Session& session, const std::string& role, const std::vector<std::string>& files,
                  const ArmModel& model, const CsvOptions& csv) {
  PoseSet all;
  for (const std::string& file : files) {
    PoseSet set = readPoses(session, role, file, model, csv);
    for (const Pose& pose : set.poses) {
      if (std::ranges::find(all.poses, pose.name, &Pose::name) != all.poses.end()) {
        throw DataError(fmt::format("{}: found a pose {}, which {} has, too; expected names of its own", file,
                                    pose.name, all.file));
      }
    }
    requireOtherPoses(set, all, "the same readings twice are no more evidence");
    std::ranges::move(set.poses, std::back_inserter(all.poses));
    all.file += (all.file.empty() ? "" : ", ") + file;
  }
  return all;
}

MotionSet readMotions(Session& session, const std::string& role, const std::string& file, const ArmModel& model,
                      bool skip_bad_rows, double restart) {
  CsvOptions csv;
  csv.skip_bad_rows = skip_bad_rows;
  MotionSet set = readMotionsFor(
      model, YamlNode::parse(session.read(role, file).content, file), file,
      [&](const std::filesystem::path& path) {
        CsvTable table = CsvTable::parse(session.take(role + " table", path), path.string(), csv);
        warnOfSkippedRows(table);
        return table;
      },
      restart);
  for (const std::string& note : set.notes) spdlog::warn("{}", note);
  return set;
}

LogTable readLog(Session& session, const std::string& role, const std::string& file, const LogFileOptions& options,
                 const std::vector<std::string>& sessions) {
  std::string content = session.take(role, file);
  if (!isBag(content)) {
    if (!options.topics.empty() && role == "log") {
      throw ConfigError(fmt::format("{}: found --topic, expected it with a recording only (MCAP, rosbag2)", file));
    }
    return readLogOf(CsvTable::parse(std::move(content), file, options.csv()), sessions);
  }
  BagLog bag = readBag(std::move(content), file, options.topics, options.csv());
  for (const std::string& note : bag.notes) spdlog::warn("{}", note);
  return readLogOf(std::move(bag.table), sessions);
}

CamerasInput readCameraFiles(Session& session, const std::vector<std::filesystem::path>& files,
                             const std::filesystem::path& of_rig) {
  std::vector<CameraFile> read;
  for (const std::filesystem::path& file : files.empty() ? std::vector{of_rig} : files) {
    read.push_back({file.string(), session.read("stereo", file).content});
  }
  CamerasInput input{readCameras(read), {}};
  const bool as_it_stands = read.size() == 1 && isStereoYaml(read[0].text);
  input.yaml = as_it_stands ? read[0].text : writeStereo(input.cameras);
  return input;
}

void addCamerasOption(CLI::App& app, std::vector<std::filesystem::path>& files) {
  app.add_option("--cameras", files,
                 "another calibration than the rig's: OpenCV's YAML or XML, Kalibr's camchain, or ROS's camera_info of "
                 "the left camera and the right one")
      ->expected(1, 2);
}

Bench readRig(Session& session, const std::string& file, const std::optional<double>& ratio) {
  Bench bench;
  if (!file.empty()) bench = readBench(YamlNode::parse(session.read("bench", file).content, file));
  bench.file = file;
  if (ratio) bench.ratio = ratio;
  return bench;
}

FittedModel readModel(Session& session, const std::string& role, const std::string& file,
                      const std::vector<std::string>& kinds) {
  FittedModel model = readFittedModel(YamlNode::parse(session.read(role, file).content, file), kinds);
  model.file = file;
  return model;
}

bool namesFile(const std::string& model) {
  return std::filesystem::exists(model) || model.find('.') != std::string::npos;
}

ActuatorModel readSubject(Session& session, const std::string& model, FittedModel& fitted) {
  if (!namesFile(model)) return subjectOf(model);
  fitted = readModel(session, "model", model);
  return subjectOf(fitted);
}

}  // namespace simgap
