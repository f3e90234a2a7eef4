#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/report/poses/simulation_report.h"
#include "simgap/simulate/arm_geometry.h"
#include "simgap/simulate/possible_commands.h"

namespace simgap {
namespace {

/// Frames that the page's view in three dimensions shows.
std::vector<std::size_t> sceneRows(const MotionTrack& track, std::size_t muscles) {
  constexpr std::size_t kMostFrames = 100, kMostLines = 1500;
  const std::size_t most = std::clamp<std::size_t>(kMostLines / std::max<std::size_t>(muscles, 1), 2, kMostFrames);
  const std::size_t frames = std::min(most, track.times.size());
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < frames; ++i) {
    rows.push_back(frames < 2 ? 0 : i * (track.times.size() - 1) / (frames - 1));
  }
  return rows;
}

std::size_t nearestRow(const std::vector<double>& times, double time) {
  const auto after = std::ranges::lower_bound(times, time);
  if (after == times.end()) return times.size() - 1;
  const auto row = static_cast<std::size_t>(after - times.begin());
  return row > 0 && time - times[row - 1] < times[row] - time ? row - 1 : row;
}

void writeScene(const SimulationResult& result, const RunDirectory& directory) {
  const ArmModel& model = result.model;
  const MotionTrack& track = result.simulation.motion;
  PoseSet set;
  std::vector<PoseOutcome> outcomes;
  for (const std::size_t row : sceneRows(track, model.muscles.size())) {
    Pose pose;
    pose.name = fmt::format("{:.2f} s", track.times[row]);
    PoseOutcome outcome;
    outcome.status = PoseStatus::kSteady;
    outcome.joints.assign(track.jointsAt(row).begin(), track.jointsAt(row).end());
    for (std::size_t m = 0; m < model.muscles.size(); ++m) {
      const double length = track.cord_lengths(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(row));
      outcome.cord_expansion.push_back(length / model.muscles[m].shock_cord.rest_length - 1.0);
    }
    const auto column = static_cast<Eigen::Index>(row);
    outcome.shafts.resize(model.commands());
    Eigen::Map<Eigen::VectorXd>(outcome.shafts.data(), std::ssize(outcome.shafts)) << track.shafts.col(column),
        track.line_commands.col(column);
    pose.joints = outcome.joints;
    if (result.measured) {
      const std::size_t nearest = nearestRow(result.measured->times, track.times[row]);
      const auto joints =
          std::span(result.measured->joints).subspan(nearest * model.joints.size(), model.joints.size());
      pose.joints.assign(joints.begin(), joints.end());
    }
    set.poses.push_back(std::move(pose));
    outcomes.push_back(std::move(outcome));
  }
  const ReplayedSet replay{"motion", "simulated", model, set, outcomes};
  writeArmGeometry({&replay, 1}, directory);
}

/// Root mean square over the rows of the way between two movements of a joint. [rad], of a slide [m]
double rms(const ArmModel& model, const MeasuredMotion& measured, std::size_t joint) {
  const std::size_t joints = model.joints.size();
  double sum = 0.0;
  for (std::size_t row = 0; row < measured.times.size(); ++row) {
    const double error = jointError(model.joints[joint].type, measured.joints[row * joints + joint],
                                    measured.simulated.joints[row * joints + joint]);
    sum += error * error;
  }
  return std::sqrt(sum / static_cast<double>(measured.times.size()));
}

Json jointsJson(const SimulationResult& result) {
  const MotionTrack& track = result.simulation.motion;
  Json joints = Json::object();
  for (std::size_t j = 0; j < result.model.joints.size(); ++j) {
    const Joint& joint = result.model.joints[j];
    const JointKind& kind = kindOf(joint.type);
    double lowest = INFINITY, highest = -INFINITY, fastest = 0.0;
    for (std::size_t row = 0; row < track.times.size(); ++row) {
      const double angle = kind.shown(kind.angle(track.jointsAt(row)[j]));
      lowest = std::min(lowest, angle);
      highest = std::max(highest, angle);
      fastest = std::max(fastest, track.joint_velocities[row * track.joint_count + j].norm());
    }
    const auto key = [&](const char* name) { return fmt::format("{}_{}", name, kind.error_unit); };
    Json entry = {
        {key("first"), kind.shown(kind.angle(track.jointsAt(0)[j]))},
        {key("last"), kind.shown(kind.angle(track.jointsAt(track.times.size() - 1)[j]))},
        {key("lowest"), lowest},
        {key("highest"), highest},
        {fmt::format("fastest_{}_s", kind.unit), fastest},
        {key("half_step"),
         numberOrNull(result.simulation.check.finished ? kind.shown(result.simulation.check.joint_change[j]) : NAN)}};
    if (result.measured) entry[key("measured_rms")] = kind.shown(rms(result.model, *result.measured, j));
    joints[joint.name] = entry;
  }
  return joints;
}

Json musclesJson(const SimulationResult& result) {
  const MotionTrack& track = result.simulation.motion;
  Json muscles = Json::object();
  for (std::size_t m = 0; m < result.model.muscles.size(); ++m) {
    const auto i = static_cast<Eigen::Index>(m);
    const Eigen::Index last = track.shafts.cols() - 1;
    muscles[result.model.muscles[m].name] = {
        {"command", result.options.rollout.targets ? "joints" : std::string(columnOf(result.commands.kinds[m]).stem)},
        {"last_shaft_rad", track.shafts(i, last)},
        {"highest_tension_N", track.forces.row(i).maxCoeff()},
        {"last_tension_N", track.forces(i, last)},
        {"highest_current_A", track.currents.row(i).cwiseAbs().maxCoeff()},
        {"highest_voltage_V", track.voltages.row(i).cwiseAbs().maxCoeff()}};
  }
  return muscles;
}

Json linesJson(const SimulationResult& result) {
  const MotionTrack& track = result.simulation.motion;
  Json lines = Json::object();
  Eigen::Index i = 0;
  for (const PassiveTendon* line : commandedLines(result.model)) {
    const double sign = line->kind->at_joint ? -1.0 : 1.0;  // as in motion.csv
    const Eigen::RowVectorXd forces = sign * track.line_forces.row(i);
    const std::string unit = line->kind->at_joint ? "torque_Nm" : "tension_N";
    lines[line->name] = {{"command", fmt::format("{}_{}", line->kind->command.quantity, line->kind->command.unit)},
                         {"last_command", track.line_commands(i, forces.size() - 1)},
                         {"lowest_" + unit, forces.minCoeff()},
                         {"highest_" + unit, forces.maxCoeff()},
                         {"last_" + unit, forces[forces.size() - 1]}};
    ++i;
  }
  return lines;
}

std::string measuredCsv(const SimulationResult& result) {
  const MeasuredMotion& measured = *result.measured;
  std::vector<std::string> header{"time_s"};
  for (const Joint& joint : result.model.joints) {
    for (const char* what : {"measured", "simulated", "error"}) {
      header.push_back(fmt::format("{}_{}_{}", joint.name, what, kindOf(joint.type).error_unit));
    }
  }
  CsvWriter csv(header);
  for (std::size_t row = 0; row < measured.times.size(); ++row) {
    csv.add(measured.times[row]);
    for (std::size_t j = 0; j < result.model.joints.size(); ++j) {
      const JointKind& kind = kindOf(result.model.joints[j].type);
      const JointPosition& real = measured.joints[row * result.model.joints.size() + j];
      const JointPosition& played = measured.simulated.jointsAt(row)[j];
      csv.add(kind.shown(kind.angle(real))).add(kind.shown(kind.angle(played)));
      csv.add(kind.shown(kind.error(real, played)));
    }
    csv.endRow();
  }
  return csv.text();
}

}  // namespace

Json toJson(const SimulationResult& result) {
  const Simulation& simulation = result.simulation;
  return {
      {"format", "simgap/simulate/1"},
      {"arm", result.model.name},
      {"start", result.start},
      {"start_s", simulation.start},
      {"end_s", simulation.end},
      {"step_s", result.options.rollout.step},
      {"controller_rate_Hz", result.options.rollout.controllers.rate},
      {"rows", simulation.motion.times.size()},
      {"real_time_factor", simulation.realTimeFactor()},
      {"half_step",
       {{"finished", simulation.check.finished},
        {"energy_percent", numberOrNull(simulation.check.finished ? 100.0 * simulation.check.energy_change : NAN)}}},
      {"joints", jointsJson(result)},
      {"muscles", musclesJson(result)},
      {"lines", linesJson(result)},
      {"measured", result.measured ? Json(result.measured->file) : Json(nullptr)},
      {"notes", result.notes}};
}

Table jointMotionTable(const Json& result) {
  const bool measured = !result.at("measured").is_null();
  Table table{"Joints", {"joint", "unit", "first", "last", "lowest", "highest", "fastest", "half the step"}, {}};
  if (measured) table.header.emplace_back("rms to measured");
  for (const auto& [name, joint] : result.at("joints").items()) {
    const bool slides = joint.contains("first_mm");
    const std::string unit = slides ? "mm" : "deg";
    std::vector<std::string> row{name, unit};
    for (const char* key : {"first", "last", "lowest", "highest"}) {
      row.push_back(numberText(joint.at(fmt::format("{}_{}", key, unit)), "{:.2f}"));
    }
    row.push_back(
        numberText(joint.at(slides ? "fastest_m_s" : "fastest_rad_s"), slides ? "{:.3f} m/s" : "{:.2f} rad/s"));
    row.push_back(numberText(joint.at("half_step_" + unit), "{:.4f}"));
    if (measured) row.push_back(numberText(joint.at("measured_rms_" + unit), "{:.3f}"));
    table.rows.push_back(row);
  }
  return table;
}

Table muscleMotionTable(const Json& result) {
  Table table{
      "Muscles",
      {"muscle", "command", "last shaft [rad]", "highest tension [N]", "last [N]", "current [A]", "voltage [V]"},
      {}};
  for (const auto& [name, muscle] : result.at("muscles").items()) {
    std::vector<std::string> row{name, muscle.at("command").get<std::string>()};
    for (const char* key :
         {"last_shaft_rad", "highest_tension_N", "last_tension_N", "highest_current_A", "highest_voltage_V"}) {
      row.push_back(numberText(muscle.at(key), "{:.2f}"));
    }
    table.rows.push_back(row);
  }
  return table;
}

Table lineMotionTable(const Json& result) {
  Table table{
      "Other drives", {"drive", "command", "last command", "pulls or turns by", "lowest", "highest", "last"}, {}};
  if (!result.contains("lines")) return table;  // of a run before there were any
  for (const auto& [name, line] : result.at("lines").items()) {
    const std::string unit = line.contains("last_torque_Nm") ? "torque_Nm" : "tension_N";
    std::vector<std::string> row{name, line.at("command").get<std::string>(),
                                 numberText(line.at("last_command"), "{:g}"), unit};
    for (const char* key : {"lowest_", "highest_", "last_"}) row.push_back(numberText(line.at(key + unit), "{:.2f}"));
    table.rows.push_back(row);
  }
  return table;
}

std::string terminalTable(const SimulationResult& result) {
  const Json json = toJson(result);
  std::string text = fmt::format("{} s of {}, {:.0f} times as fast as real time on one core\n\n",
                                 numberText(result.simulation.end - result.simulation.start, "{:g}"), result.model.name,
                                 result.simulation.realTimeFactor());
  text += alignedTable(jointMotionTable(json));
  if (!json.at("muscles").empty()) text += "\n" + alignedTable(muscleMotionTable(json));
  if (!json.at("lines").empty()) text += "\n" + alignedTable(lineMotionTable(json));
  return text;
}

void writeSimulation(const SimulationResult& result, std::uint64_t seed, const RunDirectory& directory) {
  const Simulation& simulation = result.simulation;
  directory.write("motion.csv", motionCsv(result.model, simulation.motion));
  directory.write("muscles.csv", musclesCsv(result.model, result.commands, !result.options.rollout.targets,
                                            simulation.muscles, result.options.sensors, seed));
  directory.write("joints.csv", jointsCsv(result.model, simulation.joints, result.options.sensors, seed));
  if (result.measured) directory.write("measured.csv", measuredCsv(result));
  writeScene(result, directory);
}

}  // namespace simgap
