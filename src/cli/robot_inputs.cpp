#include "robot_inputs.h"

#include <fmt/format.h>

#include "inputs.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/exchange/exchange.h"
#include "simgap/measure/logs/joined_logs.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {
namespace {

Eigen::Vector3d readGravity(const std::string& text) {
  const YamlNode node = YamlNode::parse("gravity: [" + text + "]", "--gravity");
  return node.at("gravity").vector3();
}

ArmModel robotOf(Session& session, const std::string& text, const std::string& file) {
  const FileReader read = [&](const std::filesystem::path& other) { return session.read("included", other).content; };
  switch (robotFormatOf(text, file)) {
    case RobotFormat::kMjcf:
      return readMjcf(text, file, read).model;
    case RobotFormat::kUrdf:
      return readUrdf(text, file).model;
    case RobotFormat::kSdf:
      return readSdf(text, file).model;
    case RobotFormat::kArm:
      break;
  }
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  return readArm(YamlNode::parse(text, file), [&](const std::string& mesh) { return read(folder / mesh); });
}

}  // namespace

ArmModel readRobotFile(Session& session, const std::string& file, const std::string& gravity) {
  ArmModel arm = robotOf(session, session.read("robot", file).content, file);
  if (!gravity.empty()) arm.gravity = readGravity(gravity);
  return arm;
}

std::optional<RobotModel> findRobotModel(Session& session, const std::string& file) {
  const std::string& text = session.read("model", file).content;
  if (robotFormatOf(text, file) != RobotFormat::kArm) return robotModelOf(robotOf(session, text, file));
  const YamlNode root = YamlNode::parse(text, file);
  const std::string format = root.isMap() && root.has("format") ? root.at("format").text() : "";
  if (format == "simgap/dynamics/1") return readRobotModel(root);
  if (format.starts_with("simgap/arm/")) return robotModelOf(robotOf(session, text, file));
  return std::nullopt;
}

RobotLog readRobotLogs(Session& session, std::span<const LoggedJoint> joints, const std::vector<std::string>& files,
                       const LogFileOptions& options) {
  std::vector<LogTable> logs;
  for (const std::string& file : files) logs.push_back(readLog(session, "log", file, options));
  LogTable all = logs.size() == 1 ? std::move(logs.front()) : joinedLogs(std::move(logs));
  const std::vector<std::string> summary = all.summary();
  RobotLog log = readRobotLog(std::move(all.table), joints);
  log.warnings.insert(log.warnings.end(), summary.begin(), summary.end());
  return log;
}

}  // namespace simgap
