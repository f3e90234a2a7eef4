#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <iostream>
#include <utility>

#include "cli/exo_simulation.h"
#include "cli/inputs.h"
#include "simgap/cli/command.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/poses/simulation_report.h"
#include "simgap/simulate/joint_targets.h"
#include "simgap/simulate/motion_inputs.h"
#include "simgap/simulate/possible_commands.h"
#include "simgap/simulate/served_arm.h"

namespace simgap::commands::simulate {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::string model, commands, config, measured;
  std::string hold = "step", start = "rest", start_pose;
  std::optional<double> rate, step, duration;
  bool serve = false;
};

SimulationOptions settingsOf(Session& session, const Options& options) {
  SimulationOptions settings;
  if (!options.config.empty()) {
    settings = SimulationOptions::read(YamlNode::parse(session.read("config", options.config).content, options.config));
  }
  settings.rate = options.rate.value_or(settings.rate);
  settings.rollout.step = options.step.value_or(settings.rollout.step);
  settings.rollout.validate();
  return settings;
}

bool isSchedule(const Options& options) {
  return options.commands.ends_with(".yaml") || options.commands.ends_with(".yml");
}

/// Commands of the muscles, or positions of the joints, which go into the settings.
MotionCommands readMotionCommands(Session& session, const Options& options, const ArmModel& model,
                                  SimulationOptions& settings) {
  const std::string& text = session.read("commands", options.commands).content;
  if (!isSchedule(options)) {
    const CsvTable table = CsvTable::parse(text, options.commands, options.table.csv());
    const bool linear = options.hold == "linear";
    if (!hasJointTargets(table, model)) return readCommands(table, model, linear);
    settings.rollout.targets = std::make_shared<JointTargets>(readJointTargets(table, model, linear));
    return commandsFor(*settings.rollout.targets, model.muscles.size());
  }
  return readSchedule(YamlNode::parse(text, options.commands), model, settings.rollout.controllers.rate,
                      [&](const std::string& file) {
                        const auto path = std::filesystem::path(options.commands).parent_path() / file;
                        return readPoses(session, "poses", path.string(), model, {});
                      });
}

MotionStart readStart(Session& session, const Options& options, const ArmModel& model, const MotionCommands& commands,
                      double settle) {
  const double time = commands.times.front();
  if (options.start == "rest") return restUnder(model, commands, time, settle);
  MotionStart start;
  if (options.start != "zero") {
    const CsvTable table =
        CsvTable::parse(session.read("start", options.start).content, options.start, options.table.csv());
    start = readMotionStart(table, model, options.start_pose);
  }
  start.time = time;
  return start;
}

/// Lines of the standard input as they come. A signal ends the wait for one, which it would not end for std::cin.
class InputLines {
 public:
  /// \returns false at the end
  bool next(std::string& line) {
    std::size_t end = 0;
    while ((end = read_.find('\n')) == std::string::npos) {
      if (!readMore()) {
        line = std::exchange(read_, {});
        return !line.empty();
      }
    }
    line = read_.substr(0, end);
    read_.erase(0, end + 1);
    return true;
  }

 private:
  bool readMore() {
    constexpr std::size_t kLongest = 1U << 20U;  // of a line [bytes]
    if (read_.size() > kLongest) throw DataError("standard input: found a line of more than 1 MiB, expected JSON");
    waitForBytes(STDIN_FILENO);
    std::array<char, 4096> bytes;
    const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (count > 0) read_.append(bytes.data(), static_cast<std::size_t>(count));
    return count > 0;
  }

  std::string read_;
};

/// A line in, a line out, until there are no more; how long a cycle took goes to stderr.
ExitCode serve(const ArmModel& model, const RolloutOptions& options) {
  std::ios::sync_with_stdio(false);  // character by character otherwise
  ServedArm arm(model, options);
  InputLines lines;
  std::string line;
  long cycles = 0;
  double busy = 0.0, simulated = 0.0;
  while (lines.next(line)) {
    const std::clock_t begin = std::clock();
    const double before = arm.time();
    const std::string answer = arm.answer(line);
    busy += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    simulated += std::max(0.0, arm.time() - before);
    ++cycles;
    if (!(std::cout << answer << '\n' << std::flush)) throw ConfigError("the standard output cannot be written");
  }
  if (cycles > 0) {
    spdlog::info("{} lines, {:.1f} us of one core each, {:.0f} times as fast as real time", cycles,
                 1e6 * busy / static_cast<double>(cycles), simulated / std::max(busy, 1e-6));
  }
  return ExitCode::kDone;
}

/// A joint of muscles and a motor, a leg, or a drive with a cable: its controller stands in its file, and it begins at
/// rest.
ExitCode runExo(const Options& options, const YamlNode& root, Session& session, const CLI::App& app) {
  if (options.serve || !options.config.empty() || !options.measured.empty() || options.start != "rest") {
    throw ConfigError(options.model + ": found no arm, expected no --serve, --config, --measured or --start");
  }
  refuseOptions(app, {"--start-pose"}, "with " + options.model + ", which is no arm, expected it with an arm");
  if (options.commands.empty()) throw ConfigError("found no --commands, expected what it is told");
  ExoSimulateOptions exo;
  exo.common = options.common;
  exo.table = options.table;
  exo.file = options.model;
  exo.commands = options.commands;
  exo.linear = options.hold == "linear";
  exo.rate = options.rate.value_or(exo.rate);
  exo.step = options.step.value_or(exo.step);
  exo.duration = options.duration;
  return simulateExo(exo, root, session);
}

/// Options that would change nothing.
void refuseIdle(const Options& options, const CLI::App& app) {
  if (options.serve) {
    refuseOptions(app,
                  {"--commands", "--measured", "--start", "--start-pose", "--hold", "--duration-s", "--rate", "--map",
                   "--skip-bad-rows", "--output", "--dry-run"},
                  "with --serve, expected it without: commands come line by line, and nothing is written");
  }
  if (isSchedule(options)) {
    refuseOptions(app, {"--hold"}, "with a schedule, expected it with a table (CSV): segments say what lies between");
  }
  if (options.start == "rest" || options.start == "zero") {
    refuseOptions(app, {"--start-pose"}, "without a file, expected it with --start FILE");
  }
}

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  refuseIdle(options, app);
  Session session("simulate", options.common, argv);
  const YamlNode root = readModelFile(session, "model", options.model);
  if (holdsExo(root)) return runExo(options, root, session, app);
  const ArmModel model = readArm(root);
  SimulationOptions settings = settingsOf(session, options);
  if (options.serve) return serve(model, settings.rollout);
  if (options.commands.empty()) throw ConfigError("found neither --commands nor --serve, expected one of them");
  const MotionCommands commands = readMotionCommands(session, options, model, settings);
  const MotionStart start = readStart(session, options, model, commands, settings.settle);
  const double end = motionEnd(commands, options.commands, options.duration);
  std::optional<MeasuredMotion> measured;
  if (!options.measured.empty()) {
    const CsvTable table =
        CsvTable::parse(session.read("measured", options.measured).content, options.measured, options.table.csv());
    measured = readMeasuredJoints(table, model, start.time, end);
  }
  if (options.common.dry_run) {
    session.print(fmt::format("would play {:g} s of {} on {}; nothing was written\n", end - start.time,
                              options.commands, model.name));
    return ExitCode::kDone;
  }
  const std::uint64_t seed = options.common.seed.value_or(0);
  session.begin(seed);
  session.directory().write("config.resolved.yaml", settings.toYaml());
  const Simulation simulation = simulateMotion(model, commands, start, end, settings);
  if (measured) measured->simulated = playAt(model, commands, start, measured->times, settings);
  const SimulationResult result{model,
                                commands,
                                settings,
                                simulation,
                                options.start,
                                std::move(measured),
                                notesOn(model, commands, simulation, settings.rollout.step)};
  for (const std::string& note : result.notes) spdlog::warn("{}", note);
  writeSimulation(result, seed, session.directory());
  session.finish(toJson(result), terminalTable(result));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("MODEL", options->model,
                 "arm, joint of pneumatic muscles and a motor, leg in an exoskeleton, or drive with a cable (YAML)")
      ->required();
  app.add_option(
      "--commands", options->commands,
      "per muscle over time: setpoint_<m>_rad, voltage_<m>_V or force_<m>_N (CSV), or a schedule (YAML); or per "
      "joint its position, target_<joint>_rad, … (CSV); pneumatic muscles and motors at joints: as in pose sets");
  app.add_flag("--serve", options->serve, "answer lines of JSON on stdin (commands) by lines on stdout (sensors)");
  app.add_option("--config", options->config, "step, controllers and sensors (YAML)");
  app.add_option("--hold", options->hold, "between the rows of the commands: step or linear")
      ->check(CLI::IsMember({"step", "linear"}));
  app.add_option("--start", options->start,
                 "rest: under the first commands; zero: shafts 0; or a state or pose set (CSV), taken at rest");
  app.add_option("--start-pose", options->start_pose, "the pose of --start (default: its first row)");
  app.add_option("--duration-s", options->duration, "how long to play (default: to the last command) [s]")
      ->check(positiveNumber());
  app.add_option("--rate", options->rate, "rows of motion.csv per second (default 100) [Hz]")->check(positiveNumber());
  app.add_option("--step-s", options->step, "physics step (default 0.001) [s]")->check(positiveNumber());
  app.add_option("--measured", options->measured, "a recorded movement (joints.csv), shown as a ghost");
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] { return run(*options, argv, app); };
}

}  // namespace

extern const Command entry;
const Command entry{"simulate", "plays an arm with commands over time",
                    "  simgap simulate data/elbow-movement/arm.yaml \\\n"
                    "    --commands data/elbow-movement/schedule.yaml -o runs/elbow",
                    define};

}  // namespace simgap::commands::simulate
