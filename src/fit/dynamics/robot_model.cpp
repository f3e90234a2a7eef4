#include "simgap/fit/dynamics/robot_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/words.h"
#include "simgap/fit/dynamics/dynamics_sums.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::string indented(const std::string& text) {
  std::string all;
  for (std::string_view left = text; !left.empty();) all.append("  ").append(takeLine(left)).append("\n");
  return all;
}

void readParameters(const YamlNode& root, const RobotRegressor& regressor, RobotModel& model) {
  const YamlNode list = root.at("parameters");
  const std::vector<YamlNode> entries = list.items();
  if (std::ssize(entries) != regressor.columns()) {
    list.fail(fmt::format("found {} parameters, expected the {} of its robot", entries.size(), regressor.columns()));
  }
  model.parameters.resize(regressor.columns());
  model.sd.resize(regressor.columns());
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const Index at = k;
    const std::string name = entries[k].at("name").text(), unit = entries[k].at("unit").text();
    if (name != regressor.names()[k] || unit != regressor.units()[k]) {
      entries[k].fail(
          fmt::format("found {} [{}], expected {} [{}]", name, unit, regressor.names()[k], regressor.units()[k]));
    }
    model.parameters[at] = entries[k].at("value").number();
    model.sd[at] = entries[k].at("sd").number(kNonNegative);
  }
}

/// Lower triangle, a row a line.
std::string covarianceText(const MatrixXd& covariance) {
  if (covariance.size() == 0) return {};
  std::string text = "base_covariance:\n";
  for (Index i = 0; i < covariance.rows(); ++i) {
    const VectorXd row = covariance.row(i).head(i + 1);
    text += fmt::format("  - [{:.8g}]\n", fmt::join(row, ", "));
  }
  return text;
}

/// \param count  K of its robot
MatrixXd readCovariance(const YamlNode& node, Index count) {
  const std::vector<YamlNode> rows = node.items();
  if (std::ssize(rows) != count) {
    node.fail(fmt::format("found {} rows, expected one for each of {} base parameters", rows.size(), count));
  }
  MatrixXd covariance(count, count);
  for (Index i = 0; i < count; ++i) {
    const std::vector<YamlNode> values = rows[i].items();
    if (std::ssize(values) != i + 1) {
      rows[i].fail(fmt::format("found {} numbers, expected {}: a lower triangle", values.size(), i + 1));
    }
    for (Index k = 0; k <= i; ++k) covariance(i, k) = covariance(k, i) = values[k].number();
    if (!(covariance(i, i) >= 0.0)) rows[i].fail("found a negative variance, expected 0 or more");
  }
  return covariance;
}

}  // namespace

RobotModel robotModelOf(const ArmModel& arm) {
  RobotModel model;
  model.arm = arm;
  const RobotRegressor regressor(arm, friction::find(model.law));
  model.curves.resize(regressor.coordinates());
  model.parameters = model.sd = VectorXd::Zero(regressor.columns());
  model.parameters.segment(regressor.bodyColumn(0), regressor.dynamics().parameters()) =
      regressor.dynamics().parametersOf(arm);
  for (std::size_t c = 0; c < regressor.coordinates(); ++c) {
    const Joint& joint = arm.joints[regressor.dynamics().joints()[c]];
    model.parameters[regressor.frictionColumn(c)] = joint.coulomb_friction;
    model.parameters[regressor.frictionColumn(c) + 1] = joint.viscous_friction;
  }
  return model;
}

std::string writeRobotModel(const RobotModel& model) {
  const RobotRegressor regressor(model.arm, friction::find(model.law));
  std::string text =
      fmt::format("format: simgap/dynamics/1\nlaw: {}\neffort: {}\n", model.law, model.currents ? "current" : "torque");
  text += fmt::format("data: {{file: {}, sha256: {}}}\n", yamlText(model.data_file), yamlText(model.data_sha256));
  text += "joints:\n";
  for (std::size_t c = 0; c < regressor.coordinates(); ++c) {
    text += fmt::format("  - name: {}\n", yamlText(model.arm.joints[regressor.dynamics().joints()[c]].name));
    if (model.currents) text += fmt::format("    torque_constant_Nm_A: {}\n", model.torque_constants[c]);
    if (!model.presliding.empty()) text += fmt::format("    presliding: {:.6g}\n", model.presliding[c]);
    if (!model.heldout_sd.empty()) text += fmt::format("    heldout_sd: {:.6g}\n", model.heldout_sd[c]);
    if (!regressor.law().hasStribeck()) continue;
    const bool slides = model.arm.joints[regressor.dynamics().joints()[c]].slides();
    text += fmt::format("    v_s_{}: {}\n    delta: {}\n", slides ? "m_s" : "rad_s", model.curves[c].v_s,
                        model.curves[c].delta);
  }
  text += "parameters:\n";
  for (Index k = 0; k < regressor.columns(); ++k) {
    text += fmt::format("  - {{name: {}, unit: {}, value: {}, sd: {}}}\n", yamlText(regressor.names()[k]),
                        regressor.units()[k], model.parameters[k], model.sd[k]);
  }
  text += covarianceText(model.base_covariance);
  return text + "robot:\n" + indented(writeArm(model.arm));
}

RobotModel readRobotModel(const YamlNode& root) {
  RobotModel model;
  root.at("format").oneOf({"simgap/dynamics/1"});
  model.law = root.at("law").text();
  model.currents = root.at("effort").oneOf({"torque", "current"}) == "current";
  const YamlNode data = root.at("data");
  model.data_file = data.at("file").text();
  model.data_sha256 = data.at("sha256").text();
  const bool stribeck = friction::find(model.law).hasStribeck();
  const std::vector<YamlNode> joints = root.at("joints").items();
  for (const YamlNode& joint : joints) {
    joint.at("name");
    StribeckCurve& curve = model.curves.emplace_back();
    if (model.currents) model.torque_constants.push_back(joint.quantity("torque_constant", "Nm_A", kPositive));
    if (const auto travel = joint.find("presliding")) model.presliding.push_back(travel->number(kNonNegative));
    // Files of before have none: what has not been looked at of all joints is not known of any.
    if (const auto sd = joint.find("heldout_sd")) model.heldout_sd.push_back(sd->number(kNonNegative));
    if (!stribeck) continue;
    curve.v_s = joint.at(joint.has("v_s_m_s") ? "v_s_m_s" : "v_s_rad_s").number(kPositive);
    curve.delta = joint.at("delta").number(kPositive);
  }
  // What is known of its numbers depends on its robot, whose reader refuses keys that nobody has asked for.
  const std::vector<YamlNode> parameters = root.at("parameters").items();
  for (const YamlNode& entry : parameters) {
    for (const char* key : {"name", "unit", "value", "sd"}) entry.at(key);
  }
  if (const auto covariance = root.find("base_covariance")) {
    for (const YamlNode& row : covariance->items()) {
      for (const YamlNode& value : row.items()) value.number();
    }
  }
  model.arm = readArm(root.at("robot"));
  const RobotRegressor regressor(model.arm, friction::find(model.law));
  readParameters(root, regressor, model);
  if (const auto covariance = root.find("base_covariance")) {
    model.base_covariance = readCovariance(*covariance, std::ssize(baseParameters(regressor, model.arm).columns));
  }
  if (joints.size() != regressor.coordinates()) {
    root.at("joints").fail(
        fmt::format("found {} joints, expected the {} of its robot", joints.size(), regressor.coordinates()));
  }
  for (std::size_t c = 0; c < joints.size(); ++c) {
    const std::string& expected = model.arm.joints[regressor.dynamics().joints()[c]].name;
    const YamlNode name = joints[c].at("name");
    if (name.text() != expected) name.fail(fmt::format("found {}, expected {}, as its robot", name.text(), expected));
  }
  const auto requireAllOrNone = [&](const char* key, std::size_t found) {
    if (found == 0 || found == joints.size()) return;
    root.at("joints").fail(
        fmt::format("found {} of {} joints, expected it of all {} or of none", key, found, joints.size()));
  };
  requireAllOrNone("heldout_sd", model.heldout_sd.size());
  requireAllOrNone("presliding", model.presliding.size());
  return model;
}

std::vector<LoggedJoint> loggedJoints(const ArmModel& arm) {
  std::vector<LoggedJoint> joints;
  const InverseDynamics dynamics(arm);
  for (const int index : dynamics.joints()) {
    const Joint& joint = arm.joints[index];
    joints.push_back({joint.name, joint.slides(), joint.lower_limit, joint.upper_limit, {}});
  }
  return joints;
}

std::vector<LoggedJoint> loggedJoints(const RobotModel& model) {
  std::vector<LoggedJoint> joints = loggedJoints(model.arm);
  for (std::size_t c = 0; c < model.presliding.size(); ++c) joints[c].presliding = model.presliding[c];
  return joints;
}

MatrixXd predictEfforts(const RobotModel& model, const RobotLog& log) {
  const RobotRegressor regressor(model.arm, friction::find(model.law));
  MatrixXd efforts = predictTorques(log, regressor, model.parameters, model.curves);
  for (std::size_t c = 0; c < model.torque_constants.size(); ++c) efforts.col(c) /= model.torque_constants[c];
  return efforts;
}

double relativeError(const RobotLog& log, std::size_t joint, const MatrixXd& predicted) {
  double error = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    if (!log.usable[i] || !log.joints[joint].moves[i]) continue;
    const double effort = log.joints[joint].effort[i];
    error += std::pow(predicted(i, joint) - effort, 2);
    squares += effort * effort;
  }
  return squares > 0.0 ? std::sqrt(error / squares) : std::nan("");
}

}  // namespace simgap
