#include "exo_simulation.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>

#include "inputs.h"
#include "simgap/report/actuators/exo_joint_report.h"
#include "simgap/report/actuators/exo_leg_report.h"
#include "simgap/simulate/motion_inputs.h"

namespace simgap {
namespace {

CsvTable readTable(Session& session, const ExoSimulateOptions& options) {
  return CsvTable::parse(session.read("commands", options.commands).content, options.commands, options.table.csv());
}

ExoJointCommands readJointCommands(Session& session, const ExoSimulateOptions& options, double rate) {
  if (!options.commands.ends_with(".yaml") && !options.commands.ends_with(".yml")) {
    return readExoJointCommands(readTable(session, options), options.linear);
  }
  const std::string& text = session.read("commands", options.commands).content;
  return readExoJointSchedule(YamlNode::parse(text, options.commands), rate);
}

/// When a switch is played to. \throws DataError: one row alone, and no duration
double switchEnd(const LegSwitch& told, const ExoSimulateOptions& options) {
  const MotionCommands commands{{}, told.times, {}, false};
  return motionEnd(commands, options.commands, options.duration);
}

/// \param duration [s] \param rate  of the controller [Hz]
void refuseEndless(const ExoSimulateOptions& options, double duration, double rate) {
  constexpr double kMostTicks = 1e7, kSmallestStep = 1e-7;  // [s]
  if (!(options.step >= kSmallestStep)) {
    throw ConfigError(fmt::format("found --step-s {:g}, expected at least {:g}", options.step, kSmallestStep));
  }
  if (!(duration * rate <= kMostTicks)) {
    throw ConfigError(fmt::format("{}: found {:g} s at {:g} Hz, expected at most {:g} ticks of the controller",
                                  options.commands, duration, rate, kMostTicks));
  }
}

/// \param duration [s] \param rate  of the controller [Hz] \param run  plays, writes, and finishes the session
template <class Run>
ExitCode play(const ExoSimulateOptions& options, const std::string& name, double duration, double rate,
              Session& session, const Run& run) {
  refuseEndless(options, duration, rate);
  if (options.common.dry_run) {
    session.print(
        fmt::format("would play {:g} s of {} on {}; nothing was written\n", duration, options.commands, name));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  run();
  return ExitCode::kDone;
}

ExitCode simulateJoint(const ExoSimulateOptions& options, const YamlNode& root, Session& session) {
  const ExoJoint joint = readExoJoint(root, [&](const std::string& muscle) {
    return readModel(session, "muscle", (std::filesystem::path(options.file).parent_path() / muscle).string(), {"pam"});
  });
  const ExoJointCommands commands = readJointCommands(session, options, joint.rate);
  const double end = motionEnd(commands.over_time, options.commands, options.duration);
  const double duration = end - commands.over_time.times.front();
  return play(options, joint.name, duration, joint.rate, session, [&] {
    const ExoJointStudy study = studyExoJoint(joint, commands, end, options.step);
    for (const std::string& note : study.notes) spdlog::warn("{}", note);
    writeExoJoint(joint, study, options.rate, session.directory());
    const Json result = toJson(joint, commands, study);
    session.finish(result, exoJointText(result));
  });
}

ExitCode simulateLeg(const ExoSimulateOptions& options, const YamlNode& root, Session& session) {
  const ExoLeg leg = readExoLeg(root);
  const LegSwitch told = readLegSwitch(readTable(session, options));
  const double end = switchEnd(told, options), duration = end - told.times.front();
  return play(options, leg.name, duration, leg.rate, session, [&] {
    const ExoLegStudy study = studyExoLeg(leg, told, end, options.step);
    writeExoLeg(leg, study, options.rate, session.directory());
    const Json result = toJson(leg, study);
    session.finish(result, exoLegText(result));
  });
}

bool isFormat(const YamlNode& root, const char* format) {
  return root.isMap() && root.has("format") && root.at("format").isScalar() &&
         root.at("format").text().starts_with(format);
}

}  // namespace

bool holdsExo(const YamlNode& root) { return isFormat(root, "simgap/exo-joint/") || isFormat(root, "simgap/exo-leg/"); }

ExitCode simulateExo(const ExoSimulateOptions& options, const YamlNode& root, Session& session) {
  return isFormat(root, "simgap/exo-leg/") ? simulateLeg(options, root, session)
                                           : simulateJoint(options, root, session);
}

}  // namespace simgap
