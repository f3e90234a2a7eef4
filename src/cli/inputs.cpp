#include "inputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
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

std::vector<std::string> parameterPaths(ArmModel model) {
  std::vector<std::string> paths;
  visitParameters(model,
                  [&](const ParameterPath& path, const ParameterKind&, double&) { paths.push_back(path.str()); });
  return paths;
}

/// Of parameters that nobody has chosen those that the arm has: an imported one may have lines without ends of their
/// own. All where it has none of them. \param name  of where they stand, for the warning about the others
std::vector<ParameterSpace::Choice> builtInChoices(const std::vector<ParameterSpace::Choice>& choices,
                                                   const ArmModel& model, const std::string& name) {
  const std::vector<std::string> paths = parameterPaths(model);
  std::vector<ParameterSpace::Choice> matching;
  std::vector<std::string> others;
  for (const ParameterSpace::Choice& choice : choices) {
    const auto matches = [&choice](const std::string& path) { return matchesPattern(choice.pattern, path); };
    if (std::ranges::any_of(paths, matches)) {
      matching.push_back(choice);
    } else {
      others.push_back(choice.pattern);
    }
  }
  if (matching.empty()) return choices;  // refused where a space is made of them
  if (!others.empty() && !model.muscles.empty()) {
    spdlog::warn("{}: left out {}, which this arm does not have; --config FILE gives other parameters", name,
                 fmt::join(others, ", "));
  }
  return matching;
}

/// \param built_in, content  file and text of the one that is taken without a file. \param model  that has to have the
/// parameters; null: none
template <class Config>
Config readConfigOf(Session& session, const std::string& file, const char* built_in, std::string_view content,
                    const ArmModel* model) {
  const std::string name = file.empty() ? built_in : file;
  const std::string text = file.empty() ? std::string(content) : session.read("config", file).content;
  Config config = Config::read(YamlNode::parse(text, name));
  if (file.empty() && model != nullptr) config.parameters = builtInChoices(config.parameters, *model, name);
  try {
    if (model != nullptr) ParameterSpace(*model, config.parameters);
  } catch (const ConfigError& error) {
    throw ConfigError(
        fmt::format("{}: {}{}", name, error.what(),
                    file.empty() ? " (these parameters are the built-in ones; --config FILE gives others)" : ""));
  }
  return config;
}

}  // namespace

YamlNode readModelFile(Session& session, const std::string& role, const std::string& file) {
  const std::string text = session.read(role, file).content;
  if (const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
      first != std::string::npos && text[first] == '<') {
    throw ConfigError(
        fmt::format("{}: found a robot in XML, expected an arm file: convert it first, `simgap convert {} {}`", file,
                    file, std::filesystem::path(file).filename().replace_extension(".yaml").string()));
  }
  return YamlNode::parse(text, file);
}

ArmModel readArmFile(Session& session, const std::string& role, const std::string& file) {
  return readArm(readModelFile(session, role, file));
}

CalibrationConfig readConfig(Session& session, const std::string& file, const ArmModel* model) {
  const bool lines = model != nullptr && model->muscles.empty();
  return readConfigOf<CalibrationConfig>(session, file,
                                         lines ? "configs/calibrate_lines.yaml" : "configs/calibrate_arm.yaml",
                                         lines ? assets::calibrate_lines_yaml() : assets::calibrate_arm_yaml(), model);
}

MotionCalibrationConfig readMotionConfig(Session& session, const std::string& file, const ArmModel& model) {
  return readConfigOf<MotionCalibrationConfig>(session, file, "configs/calibrate_motions.yaml",
                                               assets::calibrate_motions_yaml(), &model);
}

PoseSet readPoses(Session& session, const std::string& role, const std::string& file, const ArmModel& model,
                  const CsvOptions& csv) {
  const CsvTable table = CsvTable::parse(session.read(role, file).content, file, csv);
  warnOfSkippedRows(table);
  PoseSet set = readPosesFor(model, table);
  if (const std::size_t different = countDifferent(set.poses); different < set.poses.size()) {
    spdlog::warn("{}: found {} different poses of {}: a copy to the last digit is no measurement, but counts as one",
                 file, different, set.poses.size());
  }
  return set;
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
