#include "inputs.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>

#include "simgap/core/error.h"
#include "simgap/fit/poses/replay.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/html/assets.h"

namespace simgap {
namespace {

void warnOfSkippedRows(const CsvTable& table) {
  if (table.skippedRows() > 0) spdlog::warn("{}: {} bad rows left out", table.name(), table.skippedRows());
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

LogTable readLog(Session& session, const std::string& role, const std::string& file, const CsvOptions& csv,
                 const std::vector<std::string>& sessions) {
  CsvTable table = session.readTable(role, file, csv);
  warnOfSkippedRows(table);
  return readLogTable(std::move(table), sessions);
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
  return readFittedModel(YamlNode::parse(session.read(role, file).content, file), kinds);
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
