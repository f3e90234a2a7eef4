#include "simgap/simulate/served_arm.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/run_directory.h"
#include "simgap/simulate/possible_commands.h"

namespace simgap {
namespace {

constexpr double kLongestAdvance = 60.0;  // [s]

double numberIn(const Json& json, const std::string& what) {
  if (!json.is_number()) throw DataError(fmt::format("{}: found {}, expected a number", what, json.dump()));
  return json.get<double>();
}

CommandKind kindOfKey(const std::string& muscle, const std::string& key) {
  for (const CommandKind kind : {CommandKind::kSetpoint, CommandKind::kVoltage, CommandKind::kForce}) {
    const auto [stem, unit] = columnOf(kind);
    const bool long_enough = key.size() == stem.size() + 1 + unit.size();
    if (long_enough && key.starts_with(stem) && key[stem.size()] == '_' && key.ends_with(unit)) return kind;
  }
  throw DataError(fmt::format("{}: found {}, expected setpoint_rad, voltage_V or force_N", muscle, key));
}

/// One line of JSON, put together without a tree: it is written after every step that is served.
class StateText {
 public:
  explicit StateText(double time) { format(FMT_COMPILE(R"({{"time_s":{})"), time); }
  void number(double value) { format(FMT_COMPILE("{}"), value); }
  /// A list where there are several.
  template <class Values>
  void numbers(const Values& values) {
    if (values.size() == 1) return number(values[0]);
    char before = '[';
    for (const double value : values) {
      text_.push_back(std::exchange(before, ','));
      number(value);
    }
    text_.push_back(']');
  }
  /// "name":{key:item,...} of those that belong to it; nothing when none does.
  template <class Belongs, class Item>
  void some(std::string_view name, const std::vector<std::string>& keys, const Belongs& belongs, const Item& item) {
    bool open = false;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (!belongs(i)) continue;
      if (!std::exchange(open, true)) {
        format(FMT_COMPILE(R"(,"{}":{{)"), name);
      } else {
        text_.push_back(',');
      }
      format(FMT_COMPILE("{}:"), keys[i]);
      item(i);
    }
    if (open) text_.push_back('}');
  }
  /// The same of all, also when there is none.
  template <class Item>
  void all(std::string_view name, const std::vector<std::string>& keys, const Item& item) {
    if (keys.empty()) return format(FMT_COMPILE(R"(,"{}":{{}})"), name);
    some(
        name, keys, [](std::size_t) { return true; }, item);
  }
  std::string closed() {
    text_.push_back('}');
    return fmt::to_string(text_);
  }

 private:
  template <class Format, class... Values>
  void format(const Format& how, const Values&... values) {
    fmt::format_to(fmt::appender(text_), how, values...);
  }
  fmt::memory_buffer text_;
};

}  // namespace

/// A line understood; nothing of the arm has changed yet.
struct ServedArm::Request {
  bool reset = false;
  long steps = 0;
  std::vector<CommandKind> kinds;
  std::vector<double> commands;
};

ServedArm::ServedArm(const ArmModel& model, const RolloutOptions& options)
    : model_(model),
      options_(options),
      rollout_(model, options),
      kinds_(model.muscles.size(), CommandKind::kSetpoint),
      commands_(model.commands(), 0.0) {
  for (const Joint& joint : model.joints) joint_keys_.push_back(Json(joint.name).dump());
  for (const Muscle& muscle : model.muscles) muscle_keys_.push_back(Json(muscle.name).dump());
  for (const PassiveTendon* line : commandedLines(model_)) {
    lines_.push_back(line);
    line_keys_.push_back(Json(line->name).dump());
  }
  rollout_.begin(kinds_, {});
}

/// A line's command, `{"pressure_Pa": 2e5}`. \returns false: no line has that name
bool ServedArm::readLine(const std::string& name, const Json& command, Request& request) const {
  for (std::size_t l = 0; l < lines_.size(); ++l) {
    if (lines_[l]->name != name) continue;
    const TendonCommand& kind = lines_[l]->kind->command;
    const std::string key = fmt::format("{}_{}", kind.quantity, kind.unit);
    if (!command.is_object() || command.size() != 1 || command.begin().key() != key) {
      throw DataError(fmt::format("{}: expected {}", name, key));
    }
    const double value = numberIn(command.begin().value(), name);
    const std::string problem = problemOf(*lines_[l], value);
    if (!problem.empty()) throw DataError(fmt::format("{}: {}", name, problem));
    request.commands[kinds_.size() + l] = value;
    return true;
  }
  return false;
}

ServedArm::Request ServedArm::read(std::string_view line) const {
  Json json;
  try {
    json = Json::parse(line);
  } catch (const Json::exception&) {
    throw DataError("found no JSON, expected an object on one line");
  }
  if (!json.is_object()) throw DataError("found no object, expected one on one line");
  Request request{false, std::lround(1.0 / (options_.controllers.rate * options_.step)), kinds_, commands_};
  if (json.contains("reset")) {
    if (!json["reset"].is_boolean()) throw DataError("reset: expected true or false");
    request.reset = json["reset"].get<bool>();
    if (request.reset) request.steps = 0;
  }
  if (request.reset) {
    request.kinds.assign(kinds_.size(), CommandKind::kSetpoint);
    request.commands.assign(commands_.size(), 0.0);
  } else if (blown_up_) {
    throw DataError("the simulation has blown up, expected \"reset\": true");
  }
  for (const auto& [key, value] : json.items()) {
    if (key == "advance_s") {
      const double steps = numberIn(value, key) / options_.step;
      if (!(steps >= 0.0 && steps * options_.step <= kLongestAdvance) || std::abs(steps - std::round(steps)) > 1e-6) {
        throw DataError(fmt::format("advance_s: found {}, expected a whole number of steps of {:g} s, at most {:g} s",
                                    value.dump(), options_.step, kLongestAdvance));
      }
      request.steps = std::lround(steps);
    } else if (key == "commands") {
      if (!value.is_object()) throw DataError("commands: expected an object of muscles");
      for (const auto& [name, command] : value.items()) {
        if (readLine(name, command, request)) continue;
        const auto muscle = std::ranges::find(model_.muscles, name, &Muscle::name);
        if (muscle == model_.muscles.end()) throw DataError(fmt::format("commands: no muscle '{}'", name));
        if (!command.is_object() || command.size() != 1) {
          throw DataError(fmt::format("{}: expected one of setpoint_rad, voltage_V and force_N", name));
        }
        const auto m = static_cast<std::size_t>(muscle - model_.muscles.begin());
        request.kinds[m] = kindOfKey(name, command.begin().key());
        request.commands[m] = numberIn(command.begin().value(), name);
        const std::string problem = problemOf(*muscle, request.kinds[m], request.commands[m]);
        if (!problem.empty()) throw DataError(fmt::format("{}: {}", name, problem));
        if (!request.reset && rollout_.time() > 0.0 && request.kinds[m] != kinds_[m]) {
          throw DataError(fmt::format("{}: commanded by {} since the last reset, expected the same", name,
                                      columnOf(kinds_[m]).stem));
        }
      }
    } else if (key != "reset") {
      throw DataError(fmt::format("found {}, expected commands, advance_s and reset", key));
    }
  }
  return request;
}

std::string ServedArm::answer(std::string_view line) {
  try {
    Request request = read(line);
    if (request.reset || request.kinds != kinds_) {
      rollout_.begin(request.kinds, {});
      blown_up_ = false;
    }
    kinds_ = std::move(request.kinds);
    commands_ = std::move(request.commands);
    for (long i = 0; i < request.steps; ++i) {
      if (rollout_.step(commands_)) continue;
      blown_up_ = true;
      throw NumericsError(fmt::format("the simulation blew up at {:g} s; a smaller --step-s than {:g} may hold",
                                      rollout_.time(), options_.step));
    }
    return state();
  } catch (const Error& error) {
    return Json{{"error", error.what()}}.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
}

/// Written by hand: a cycle of 2 ms is to take some 10 us, which is what a tree of JSON takes to be made and written.
std::string ServedArm::state() const {
  const BulletArm& arm = rollout_.arm();
  StateText text(rollout_.time());
  text.all("joints", joint_keys_,
           [&](std::size_t j) { text.numbers(kindOf(model_.joints[j].type).cells(arm.jointPosition(j))); });
  const auto velocity = [&](std::size_t j) {
    const Eigen::Vector3d v = arm.jointVelocity(j);
    text.numbers(std::span(v.data(), model_.joints[j].hasAxis() ? 1 : 3));
  };
  const auto slides = [&](std::size_t j) { return model_.joints[j].slides(); };
  text.some("joint_velocities_rad_s", joint_keys_, std::not_fn(slides), velocity);
  text.some("joint_velocities_m_s", joint_keys_, slides, velocity);
  text.all("shaft_rad", muscle_keys_, [&](std::size_t m) { text.number(arm.shaftAngle(m)); });
  text.all("force_N", muscle_keys_, [&](std::size_t m) { text.number(arm.force(m)); });
  text.all("current_A", muscle_keys_, [&](std::size_t m) { text.number(arm.current(m)); });
  // As in motion.csv: along a line, about a joint.
  const auto at_joint = [&](std::size_t l) { return lines_[l]->kind->at_joint; };
  text.some("tension_N", line_keys_, std::not_fn(at_joint), [&](std::size_t l) { text.number(arm.lineForce(l)); });
  text.some("torque_Nm", line_keys_, at_joint, [&](std::size_t l) { text.number(-arm.lineForce(l)); });
  return text.closed();
}

}  // namespace simgap
