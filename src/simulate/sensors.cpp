#include "simgap/simulate/sensors.h"

#include <fmt/format.h>

#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/random.h"

namespace simgap {
namespace {

/// Channels of noise, for CounterRandom.
enum class Channel : std::uint32_t { kShaft, kForce, kCurrent, kJoint };

double normal(const CounterRandom& random, Channel channel, std::size_t row, std::size_t item, std::uint32_t axis = 0) {
  return random.normalPair({static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(item), axis,
                            static_cast<std::uint32_t>(channel)})[0];
}

double sensed(double value, const SensorNoise& sensor, double normal_number) {
  const double noisy = value + sensor.noise * normal_number;
  return sensor.quantisation > 0.0 ? sensor.quantisation * std::round(noisy / sensor.quantisation) : noisy;
}

void readClock(const YamlNode& node, SensorClock& clock) {
  clock.rate = node.findQuantity("rate", "Hz", kPositive).value_or(clock.rate);
  clock.offset = node.findQuantity("clock_offset", "s").value_or(clock.offset);
  if (const auto drift = node.find("clock_drift_ppm")) {
    // A clock that runs backwards, or ten times as fast, is a slip of the unit, and its file is no recording.
    clock.drift = 1e-6 * drift->number({-1e5, 1e5, false, "-100000 to 100000 ppm"});
  }
}

void readNoise(const YamlNode& node, const std::string& name, std::string_view unit, SensorNoise& sensor) {
  sensor.noise = node.findQuantity(name + "_noise", unit, kNonNegative).value_or(sensor.noise);
  sensor.quantisation = node.findQuantity(name + "_quantisation", unit, kNonNegative).value_or(sensor.quantisation);
}

std::string clockYaml(const SensorClock& clock) {
  return fmt::format("rate_Hz: {}, clock_offset_s: {}, clock_drift_ppm: {}", clock.rate, clock.offset,
                     1e6 * clock.drift);
}

}  // namespace

SensorOptions SensorOptions::read(const YamlNode& node) {
  SensorOptions options;
  if (const auto muscles = node.find("muscles")) {
    readClock(*muscles, options.muscles);
    readNoise(*muscles, "shaft", "rad", options.shaft);
    readNoise(*muscles, "force", "N", options.force);
    readNoise(*muscles, "current", "A", options.current);
  }
  if (const auto joints = node.find("joints")) {
    readClock(*joints, options.joints);
    options.joint_noise = joints->findQuantity("noise", "rad", kNonNegative).value_or(0.0);
    options.slide_noise = joints->findQuantity("slide_noise", "m", kNonNegative).value_or(0.0);
  }
  return options;
}

std::string SensorOptions::toYaml() const {
  return fmt::format(
      "sensors:\n"
      "  muscles: {{{}, shaft_noise_rad: {}, shaft_quantisation_rad: {},\n"
      "    force_noise_N: {}, force_quantisation_N: {}, current_noise_A: {}, current_quantisation_A: {}}}\n"
      "  joints: {{{}, noise_rad: {}, slide_noise_m: {}}}\n",
      clockYaml(muscles), shaft.noise, shaft.quantisation, force.noise, force.quantisation, current.noise,
      current.quantisation, clockYaml(joints), joint_noise, slide_noise);
}

std::vector<double> sensorTimes(const SensorClock& clock, double start, double end) {
  constexpr double kMostRows = 1e7;  // a gigabyte of motion, and more than any rig records in a run
  if (!((end - start) * clock.rate < kMostRows)) {
    throw ConfigError(
        fmt::format("found {:g} s at {:g} Hz, expected at most {:g} rows", end - start, clock.rate, kMostRows));
  }
  std::vector<double> times;
  for (long i = 0; start + static_cast<double>(i) / clock.rate <= end + 1e-9; ++i) {
    times.push_back(start + static_cast<double>(i) / clock.rate);
  }
  return times;
}

std::string musclesCsv(const ArmModel& model, const MotionCommands& commands, bool with_commands,
                       const MotionTrack& track, const SensorOptions& options, std::uint64_t seed) {
  const CounterRandom random(seed);
  std::vector<std::string> header{"time_s"};
  for (std::size_t m = 0; with_commands && m < model.muscles.size(); ++m) {
    const auto [stem, unit] = columnOf(commands.kinds[m]);
    header.push_back(fmt::format("{}_{}_{}", stem, model.muscles[m].name, unit));
  }
  for (const Muscle& muscle : model.muscles) header.push_back(fmt::format("shaft_{}_rad", muscle.name));
  for (const Muscle& muscle : model.muscles) header.push_back(fmt::format("current_{}_A", muscle.name));
  for (const Muscle& muscle : model.muscles) header.push_back(fmt::format("measured_force_{}_N", muscle.name));
  const std::vector<CommandChannel> lines = model.poseLayout().lines;
  for (std::size_t l = 0; with_commands && l < lines.size(); ++l) {
    header.push_back(fmt::format("{}_{}", lines[l].stem, lines[l].unit));
  }
  CsvWriter csv(header);
  std::vector<double> values(model.commands());
  std::size_t command_row = 0;
  for (std::size_t row = 0; row < track.times.size(); ++row) {
    const auto column = static_cast<Eigen::Index>(row);
    csv.add(options.muscles.reads(track.times[row]));
    commands.at(track.times[row], command_row, values);
    for (std::size_t m = 0; with_commands && m < model.muscles.size(); ++m) csv.add(values[m]);
    const auto add = [&](const Eigen::MatrixXd& truth, const SensorNoise& sensor, Channel channel) {
      for (Eigen::Index m = 0; m < truth.rows(); ++m) {
        csv.add(sensed(truth(m, column), sensor, normal(random, channel, row, static_cast<std::size_t>(m))));
      }
    };
    add(track.shafts, options.shaft, Channel::kShaft);
    add(track.currents, options.current, Channel::kCurrent);
    add(track.forces, options.force, Channel::kForce);
    for (std::size_t l = 0; with_commands && l < lines.size(); ++l) csv.add(values[model.muscles.size() + l]);
    csv.endRow();
  }
  return csv.text();
}

std::string jointsCsv(const ArmModel& model, const MotionTrack& track, const SensorOptions& options,
                      std::uint64_t seed) {
  const CounterRandom random(seed);
  std::vector<std::string> header{"time_s"};
  for (const Joint& joint : model.joints) {
    for (const std::string& column : positionColumns(joint.type, joint.name)) header.push_back(column);
  }
  CsvWriter csv(header);
  for (std::size_t row = 0; row < track.times.size(); ++row) {
    csv.add(options.joints.reads(track.times[row]));
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      Eigen::Vector3d normals;
      for (std::uint32_t axis = 0; axis < 3; ++axis) normals[axis] = normal(random, Channel::kJoint, row, j, axis);
      const double noise = model.joints[j].slides() ? options.slide_noise : options.joint_noise;
      const JointPosition seen = kindOf(model.joints[j].type).moved(track.jointsAt(row)[j], noise * normals);
      for (const double cell : kindOf(model.joints[j].type).cells(seen)) csv.add(cell);
    }
    csv.endRow();
  }
  return csv.text();
}

}  // namespace simgap
