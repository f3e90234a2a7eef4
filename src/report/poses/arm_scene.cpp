#include "arm_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <tuple>

namespace simgap {
namespace {

using StateKey = std::tuple<std::string, std::string, std::string>;  ///< set, pose, state

/// A tenth of a millimetre is finer than any screen.
Json tenthOfAMillimetre(double value) { return std::strtod(fmt::format("{:.4f}", value).c_str(), nullptr); }

std::vector<StateKey> stateKeys(const CsvTable& table) {
  const auto sets = table.text("set"), poses = table.text("pose"), states = table.text("state");
  std::vector<StateKey> keys;
  for (std::size_t i = 0; i < sets.size(); ++i) keys.emplace_back(sets[i], poses[i], states[i]);
  return keys;
}

Json partsJson(const CsvTable& table, const std::vector<std::string>& bodies) {
  const auto body = table.text("body"), shape = table.text("shape");
  const auto radius = numbersOf(table, "radius_m"), length = numbersOf(table, "length_m");
  const auto vectors = [&](const std::array<const char*, 3>& names) {
    std::array<std::vector<double>, 3> columns;
    for (std::size_t k = 0; k < 3; ++k) columns[k] = numbersOf(table, names[k]);
    return columns;
  };
  const auto size = vectors({"size_x_m", "size_y_m", "size_z_m"}), position = vectors({"x_m", "y_m", "z_m"});
  const auto axis = vectors({"axis_x", "axis_y", "axis_z"});
  const auto row = [](const auto& columns, std::size_t i) {
    return Json::array({columns[0][i], columns[1][i], columns[2][i]});
  };
  Json parts = Json::array();
  for (std::size_t i = 0; i < body.size(); ++i) {
    parts.push_back({{"body", std::ranges::find(bodies, body[i]) - bodies.begin()},
                     {"shape", shape[i]},
                     {"radius", radius[i]},
                     {"length", length[i]},
                     {"size", row(size, i)},
                     {"position", row(position, i)},
                     {"axis", row(axis, i)}});
  }
  return parts;
}

/// Per state: the frames of all bodies, in their order.
std::map<StateKey, Json> framesJson(const CsvTable& table) {
  const std::vector<StateKey> keys = stateKeys(table);
  std::vector<std::vector<double>> columns;
  for (const char* name : {"x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"}) columns.push_back(numbersOf(table, name));
  std::map<StateKey, Json> frames;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    Json frame = Json::array();
    for (const auto& column : columns) frame.push_back(tenthOfAMillimetre(column[i]));
    frames.try_emplace(keys[i], Json::array()).first->second.push_back(frame);
  }
  return frames;
}

/// Per state: the paths of all muscles, each as [muscle, tension, x, y, z, x, y, z, …].
std::map<StateKey, Json> pathsJson(const CsvTable& table, const std::vector<std::string>& muscles) {
  const std::vector<StateKey> keys = stateKeys(table);
  const auto muscle = table.text("muscle");
  const auto x = numbersOf(table, "x_m"), y = numbersOf(table, "y_m"), z = numbersOf(table, "z_m");
  const auto tension = numbersOf(table, "tension_N");
  std::map<StateKey, Json> paths;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    Json& list = paths.try_emplace(keys[i], Json::array()).first->second;
    const auto index = std::ranges::find(muscles, muscle[i]) - muscles.begin();
    if (list.empty() || list.back().at(0) != index) list.push_back({index, std::round(100.0 * tension[i]) / 100.0});
    for (const double value : {x[i], y[i], z[i]}) list.back().push_back(tenthOfAMillimetre(value));
  }
  return paths;
}

}  // namespace

std::optional<PageScene> armScene(const ResultFiles& files, std::vector<ScenePose> poses,
                                  const std::optional<SceneMotion>& motion) {
  if (poses.empty() || !files.has("arm_bodies.csv")) return std::nullopt;
  const CsvTable body_table = files.table("arm_bodies.csv");
  const std::vector<std::string> bodies = distinctOf(body_table, "body");
  const auto frames = framesJson(body_table);
  const CsvTable muscle_table = files.table("arm_muscles.csv");
  const std::vector<std::string> muscles = distinctOf(muscle_table, "muscle");
  const auto paths = pathsJson(muscle_table, muscles);
  const std::vector<double> tensions = numbersOf(muscle_table, "tension_N");
  const std::size_t count = poses.size();
  poses.resize(std::min({count, kMostScenePoses, kMostPaths / std::max<std::size_t>(muscles.size(), 1)}));
  Json list = Json::array(), states = Json::array();
  for (const auto& [state, text] : poses.front().states) states.push_back(state);
  for (const ScenePose& pose : poses) {
    Json shown = Json::object();
    const auto show = [&](const std::string& state, const std::string& text) {
      const StateKey key{pose.set, pose.pose, state};
      if (!frames.contains(key)) return;
      shown[state] = {{"text", text}, {"bodies", frames.at(key)}};
      if (paths.contains(key)) shown[state]["paths"] = paths.at(key);
    };
    show("measured", "");
    for (const auto& [state, text] : pose.states) show(state, text);
    list.push_back({{"name", motion ? pose.pose : pose.set + " pose " + pose.pose}, {"states", shown}});
  }
  PageScene scene{motion ? "The movement" : "The arm in its poses", "", {}};
  scene.note = !motion || motion->measured ? "Solid: simulated; ghost: measured. " : "";
  scene.note +=
      "A muscle's colour and thickness grow with its tension. Drag or use the arrow keys to turn; click, then scroll "
      "to "
      "come nearer.";
  if (count > poses.size()) scene.note += fmt::format(" The {} worst of {} poses.", poses.size(), count);
  scene.scene = {{"slider", motion ? "time" : "pose, worst first"},
                 {"states", states},
                 {"ghost", !motion || motion->measured ? Json("measured") : Json(nullptr)},
                 {"bodies", bodies},
                 {"parts", partsJson(files.table("arm_parts.csv"), bodies)},
                 {"muscles", muscles},
                 {"most_tension", tensions.empty() ? 0.0 : std::ranges::max(tensions)},
                 {"poses", list}};
  if (motion) scene.scene["duration_s"] = motion->duration;
  return scene;
}

}  // namespace simgap
