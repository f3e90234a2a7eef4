#include "exo_simulation.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>

#include "inputs.h"
#include "simgap/report/actuators/cable_drive_report.h"
#include "simgap/report/actuators/exo_joint_report.h"
#include "simgap/report/actuators/exo_leg_report.h"
#include "simgap/simulate/motion_inputs.h"

namespace simgap {
namespace {

CsvTable readTable(Session& session, const ExoSimulateOptions& options) {
  return CsvTable::parse(session.read("commands", options.commands).content, options.commands, options.table.csv());
}

/// Commands as a table or a schedule holds them.
template <class Table, class Schedule>
auto readTold(Session& session, const ExoSimulateOptions& options, const Table& table, const Schedule& schedule) {
  if (!options.commands.ends_with(".yaml") && !options.commands.ends_with(".yml")) {
    return table(readTable(session, options), options.linear);
  }
  return schedule(YamlNode::parse(session.read("commands", options.commands).content, options.commands));
}

/// The file of a fitted model that another one names, beside which it stands.
FittedModel readNamedModel(Session& session, const ExoSimulateOptions& options, const std::string& role,
                           const std::string& file, const std::string& kind) {
  return readModel(session, role, (std::filesystem::path(options.file).parent_path() / file).string(), {kind});
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

/// Torques, pressures, or a switch between two torques, as a decoder leaves it.
ExoJointCommands readJointCommands(const ExoJoint& joint, const ExoSimulateOptions& options, Session& session) {
  return readTold(
      session, options,
      [&](const CsvTable& table, bool linear) {
        if (!table.has("state")) return readExoJointCommands(joint, table, linear);
        const LegSwitch told = readLegSwitch(table);
        const double end = switchEnd(told, options);
        refuseEndless(options, end - told.times.front(), joint.rate);
        return switchedTorques(joint, told, end);
      },
      [&](const YamlNode& schedule) { return readExoJointSchedule(joint, schedule); });
}

ExitCode simulateJoint(const ExoSimulateOptions& options, const YamlNode& root, Session& session) {
  const ExoJoint joint = readExoJoint(
      root, [&](const std::string& muscle) { return readNamedModel(session, options, "muscle", muscle, "pam"); });
  const ExoJointCommands commands = readJointCommands(joint, options, session);
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
    for (const std::string& note : study.notes) spdlog::warn("{}", note);
    writeExoLeg(leg, study, options.rate, session.directory());
    const Json result = toJson(leg, study);
    session.finish(result, exoLegText(result));
  });
}

ExitCode simulateDrive(const ExoSimulateOptions& options, const YamlNode& root, Session& session) {
  const CableDrive drive = readCableDrive(root, [&](const std::string& friction) {
    return readNamedModel(session, options, "friction", friction, "friction");
  });
  const CableDriveCommands commands = readTold(session, options, readCableDriveCommands, [&](const YamlNode& schedule) {
    return readCableDriveSchedule(schedule, drive.rate);
  });
  const double end = motionEnd(commands.over_time, options.commands, options.duration);
  const double duration = end - commands.over_time.times.front();
  return play(options, drive.name, duration, drive.rate, session, [&] {
    const CableDriveStudy study = studyCableDrive(drive, commands, end, options.step, options.rate);
    for (const std::string& note : study.notes) spdlog::warn("{}", note);
    writeCableDrive(study, commands.torque, session.directory());
    const Json result = toJson(drive, commands, study);
    session.finish(result, cableDriveText(result));
  });
}

bool isFormat(const YamlNode& root, const char* format) {
  return root.isMap() && root.has("format") && root.at("format").isScalar() &&
         root.at("format").text().starts_with(format);
}

}  // namespace

bool holdsExo(const YamlNode& root) {
  return isFormat(root, "simgap/exo-joint/") || isFormat(root, "simgap/exo-leg/") ||
         isFormat(root, "simgap/cable-drive/");
}

ExitCode simulateExo(const ExoSimulateOptions& options, const YamlNode& root, Session& session) {
  if (isFormat(root, "simgap/exo-leg/")) return simulateLeg(options, root, session);
  return isFormat(root, "simgap/cable-drive/") ? simulateDrive(options, root, session)
                                               : simulateJoint(options, root, session);
}

}  // namespace simgap
