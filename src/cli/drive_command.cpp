#include "drive_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "inputs.h"
#include "simgap/core/error.h"
#include "simgap/report/actuators/drive_report.h"

namespace simgap {
namespace {

/// Nothing of a motor alone depends on them.
bool isOfGearbox(const std::string& parameter) {
  const std::vector<std::string> names = driveParameterNames();
  const auto place = static_cast<std::size_t>(std::ranges::find(names, parameter) - names.begin());
  return place >= kMotorParameters && place < kDriveParameters;
}

/// A gearbox's fit holds the motor at what its own fit said: bounds of it would change nothing.
void refuseBoundsOfMotor(const ParameterChoices& choices) {
  for (const auto& [name, range] : choices.bounds) {
    if (isOfGearbox(name) || name.ends_with("_delay")) continue;
    throw ConfigError(fmt::format(
        "--bounds {}: found a parameter of the motor, which --motor tells, expected one of the gearbox", name));
  }
}

}  // namespace

std::optional<ArmWithDrive> readTarget(const std::string& into, const std::string& muscle, Session& session) {
  if (into.empty() != muscle.empty()) throw ConfigError("--into and --muscle go together");
  if (into.empty()) return std::nullopt;
  ArmWithDrive target{readArmFile(session, "arm", into), 0};
  const std::vector<Muscle>& muscles = target.arm.muscles;
  const auto found = std::ranges::find(muscles, muscle, &Muscle::name);
  if (found == muscles.end()) {
    throw ConfigError(fmt::format("{}: found no muscle {}, expected one that the arm has", into, muscle));
  }
  target.muscle = static_cast<std::size_t>(found - muscles.begin());
  return target;
}

void DriveCommandOptions::add(CLI::App& command) {
  app = &command;
  command
      .add_option("LOG", log,
                  "log of the drive (CSV: time_s and what there is of voltage_V, current_A, velocity_rad_s, "
                  "load_torque_Nm)")
      ->required();
  command.add_option("--into", into,
                     "arm model (YAML) to write the result into; the copy lands in the result directory");
  command.add_option("--muscle", muscle, "whose drive it is");
  fit.add(command);
  table.add(command);
  common.add(command);
}

ExitCode runDriveFit(const std::string& kind, const DriveCommandOptions& options, Session& session,
                     DriveFitOptions drive) {
  DriveReport report;
  report.kind = kind;
  report.ratio = drive.ratio;
  report.into = readTarget(options.into, options.muscle, session);
  const ParameterChoices choices = options.fit.parameters();
  std::vector<std::string> names = driveParameterNames();
  if (!drive.fit_gearbox) std::erase_if(names, isOfGearbox);
  requireKnown(choices, names);
  if (!drive.fit_motor) refuseBoundsOfMotor(choices);
  drive.fixed = choices.fixed;
  drive.bounds = choices.bounds;
  const LogTable rows = readLog(session, "log", options.log, options.table, options.fit.sessions);
  const Holdout holdout = readHoldout(options.fit.holdout, rows.table);
  report.log = readMotorLog(rows.table);
  report.log_file = options.log;
  report.log_sha256 = session.input("log").sha256;
  if (options.common.dry_run) {
    session.print(
        fmt::format("would fit a {} to {} rows of {}; nothing was written\n", kind, report.log.rows(), options.log));
    return ExitCode::kDone;
  }
  report.fit = fitAndJudge(report.log, drive, holdout, options.fit.block_s);
  finishFit(session, *options.app, summarise(report), rows.summary(),
            [&](const RunDirectory& directory) { writeDriveReport(report, directory); });
  return ExitCode::kDone;
}

}  // namespace simgap
