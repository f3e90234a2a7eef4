#include "simgap/simulate/robot_exchange.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/core/words.h"
#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap {
namespace {

constexpr double kSameWay = 1e-6;      ///< [m] what rounding and two searches for one rest leave
constexpr double kSameTurn = 1e-5;     ///< [rad]
constexpr double kSameMass = 1e-6;     ///< [kg]
constexpr double kSameInertia = 1e-4;  ///< as a share

ImportedArm readRobot(const RobotFile& from, RobotFormat format, const FileReader& read) {
  if (format == RobotFormat::kMjcf) return readMjcf(from.text, from.file, read);
  if (format == RobotFormat::kUrdf) return readUrdf(from.text, from.file);
  if (format == RobotFormat::kSdf) return readSdf(from.text, from.file);
  const MeshReader mesh = [&](const std::string& file) { return read(from.file.parent_path() / file); };
  return {readArm(YamlNode::parse(from.text, from.file.string()), mesh), {}};
}

ExportedArm writeRobot(const ArmModel& model, RobotFormat format) {
  if (format == RobotFormat::kMjcf) return writeMjcf(model);
  if (format == RobotFormat::kUrdf) return writeUrdf(model);
  return {writeArm(model), {}};
}

/// The keys of an arm file that --muscles does not take.
constexpr std::array<std::string_view, 5> kNoMuscles = {"format", "name", "gravity", "bodies", "joints"};

/// Whether a line begins another key of the file's outermost map that is not taken; unchanged by what stands in a key.
bool beginsOther(std::string_view line, bool before) {
  if (line.empty() || line.starts_with('#') || line.starts_with(' ') || line.starts_with('-')) return before;
  const std::string_view key = line.substr(0, line.find(':'));
  return std::ranges::any_of(kNoMuscles, [&](std::string_view other) {
    return key == other || (other == "gravity" && key.starts_with("gravity_"));
  });
}

/// A whole arm file, or a part of one, without what --muscles does not take; its lines keep their numbers.
std::string musclesAlone(std::string_view text) {
  std::string kept;
  for (bool other = false; !text.empty();) {
    const std::string_view line = takeLine(text);
    other = beginsOther(line, other);
    if (!other) kept.append(line);
    kept.append("\n");
  }
  return kept;
}

/// Whether the file states bodies, too.
bool isWholeArm(const RobotFile& muscles) { return ("\n" + muscles.text).find("\nbodies:") != std::string::npos; }

/// What the lines of a whole arm file bend over belongs to its bodies: it goes along to those of the same names.
void takeSurfaces(ArmModel& model, const ArmModel& whole) {
  for (const Body& from : whole.bodies) {
    const auto body = std::ranges::find(model.bodies, from.name, &Body::name);
    if (body == model.bodies.end()) continue;
    for (const Surface& surface : from.surfaces) {
      const auto known = std::ranges::find(body->surfaces, surface.name, &Surface::name);
      if (known == body->surfaces.end()) body->surfaces.push_back(surface);
    }
  }
}

/// Points of lines stand in their bodies' frames, which other formats put elsewhere (URDF: at the joint).
void nameOtherFrames(const ArmModel& model, const ArmModel& whole, std::vector<ExchangeRemark>& remarks) {
  const std::vector<BodyInWorld> here = bodiesInWorld(model, std::vector<JointPosition>(model.joints.size()));
  const std::vector<BodyInWorld> there = bodiesInWorld(whole, std::vector<JointPosition>(whole.joints.size()));
  for (std::size_t b = 0; b < whole.bodies.size(); ++b) {
    const auto body = std::ranges::find(model.bodies, whole.bodies[b].name, &Body::name);
    if (body == model.bodies.end()) continue;
    const BodyInWorld& same = here[body - model.bodies.begin()];
    if ((same.origin - there[b].origin).norm() < kSameWay && same.rotation.isApprox(there[b].rotation, kSameTurn)) {
      continue;
    }
    remarks.push_back({fmt::format("body '{}' of the muscles' file", abridged(body->name)),
                       "has its frame elsewhere there: points of lines on it are taken by their numbers",
                       true,
                       {}});
  }
}

/// The same bodies and joints with the muscles of a file, which stands first: its lines keep their numbers.
ArmModel withMuscles(ArmModel model, const RobotFile& muscles, std::vector<ExchangeRemark>& remarks) {
  model.muscles.clear();
  model.tendons.clear();
  model.extensions.clear();
  model.motor_defaults = {};
  model.gearbox_defaults = {};
  if (isWholeArm(muscles)) {
    const ArmModel whole = readArm(YamlNode::parse(muscles.text, muscles.file.string()));
    takeSurfaces(model, whole);
    nameOtherFrames(model, whole, remarks);
  }
  const std::string text = writeArm(model);
  std::string skeleton;
  for (std::string_view left = text; !left.empty();) {
    const std::string_view line = takeLine(left);
    // The later version of the format has every key that the lines of muscles may need.
    if (line.starts_with("format:")) {
      skeleton.append("format: simgap/arm/2\n");
    } else if (!line.starts_with("muscles:")) {
      skeleton.append(line).append("\n");
    }
  }
  return readArm(YamlNode::parse(musclesAlone(muscles.text) + "\n" + skeleton, muscles.file.string()));
}

/// What a reader of the file has to know, above it.
std::string comments(const RobotExchange& exchange) {
  std::string text =
      fmt::format("# from {} ({})\n", printable(exchange.from.filename().string()), nameOf(exchange.from_format));
  for (const ExchangeRemark& remark : exchange.read) {
    if (remark.matters) text += fmt::format("# {}: {}\n", printable(remark.what), printable(remark.done));
  }
  return text;
}

void checkSame(const RobotExchange& exchange) {
  const ExchangeReplay& replay = exchange.replay;
  const auto refuse = [&](const std::string& what) {
    throw NumericsError(fmt::format("{}: read back, {}; nothing was written", exchange.to.string(), what));
  };
  if (!(replay.way < kSameWay) || !(replay.turn < kSameTurn)) {
    refuse(fmt::format("a body stands {:.3g} m and {:.3g} rad elsewhere at the same position of the joints", replay.way,
                       replay.turn));
  }
  if (!(replay.mass < kSameMass) || !(replay.centre < kSameWay) || !(replay.inertia < kSameInertia)) {
    refuse(fmt::format("a body differs by {:.3g} kg, {:.3g} m of its centre and {:.3g} % of its inertia", replay.mass,
                       replay.centre, 100.0 * replay.inertia));
  }
  if (replay.restless > 0) {
    refuse(fmt::format("{} of {} poses do not come to rest", replay.restless, replay.restless + replay.rests));
  }
  if (!(replay.rest_way < kSameWay) || !(replay.rest_turn < kSameTurn)) {
    refuse(fmt::format("a body rests {:.3g} m and {:.3g} rad elsewhere at the same shafts", replay.rest_way,
                       replay.rest_turn));
  }
}

}  // namespace

RobotExchange exchangeRobot(const RobotFile& from, const RobotFile& muscles, const std::filesystem::path& to,
                            const FileReader& read) {
  RobotExchange exchange;
  exchange.from = from.file;
  exchange.to = to;
  exchange.to_format = robotFormatOf(to);
  exchange.from_format = robotFormatOf(from.text, from.file);
  ImportedArm imported = readRobot(from, exchange.from_format, read);
  exchange.read = std::move(imported.remarks);
  exchange.model =
      muscles.text.empty() ? std::move(imported.model) : withMuscles(std::move(imported.model), muscles, exchange.read);
  if (exchange.to_format != RobotFormat::kArm) {
    for (const Extension& extension : workExtensionsIn(exchange.model)) {
      const std::string on = extension.target.empty() ? "" : fmt::format(" of '{}'", extension.target);
      exchange.written.push_back(
          {fmt::format("extension '{}'{}", extension.effect, on), "worked into the robot's numbers", false, {}});
    }
  }
  ExportedArm exported = writeRobot(exchange.model, exchange.to_format);
  std::ranges::move(exported.remarks, std::back_inserter(exchange.written));
  const FileReader none = [](const std::filesystem::path& file) -> std::string {
    throw DataError(file.string() + ": found a file to include, expected none");
  };
  const ArmModel back = readRobot({exported.text, to}, exchange.to_format, none).model;
  exchange.replay = replayExchange(exchange.model, back, exchange.to_format == RobotFormat::kUrdf);
  checkSame(exchange);
  exchange.text = exchange.to_format == RobotFormat::kArm ? comments(exchange) + exported.text : exported.text;
  return exchange;
}

}  // namespace simgap
