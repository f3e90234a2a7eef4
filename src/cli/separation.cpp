#include "separation.h"

#include <fmt/format.h>

#include <optional>

#include "cli/inputs.h"
#include "cli/motion_commands.h"
#include "cli/pose_evidence.h"
#include "simgap/core/progress.h"
#include "simgap/report/diagnosis/candidate_files.h"
#include "simgap/report/diagnosis/log_intervention_report.h"
#include "simgap/report/diagnosis/separation_report.h"

namespace simgap {
namespace {

LogChanges protocolOf(double speed, double load) {
  std::string yaml = fmt::format("format: simgap/change/1\nname: speed x {:g}, load x {:g}\nchanges:\n", speed, load);
  yaml += fmt::format("  - {{kind: speed, factor: {}}}\n", speed);
  if (load != 1.0) yaml += fmt::format("  - {{kind: load, factor: {}}}\n", load);
  return LogChanges::read(YamlNode::parse(yaml, "--speeds, --loads"));
}

ExitCode separateLogs(const SeparateOptions& options, Session& session, const CLI::App& app) {
  const LogEvidence evidence = readLogEvidence(options.of, session);
  // A load that no sensor shows is the bench's own: it cannot be multiplied.
  const bool sensed =
      evidence.bench.load == BenchLoad::kTorqueSensor && (evidence.candidates.front().model.kind == "friction");
  if (!sensed) refuseOptions(app, {"--loads"}, "where no sensor shows the load, expected --speeds alone");
  const std::vector<double> loads = sensed ? options.loads : std::vector{1.0};
  if (options.of.common.dry_run) {
    session.print(fmt::format("would ask {} models for {} motions; nothing was written\n", evidence.candidates.size(),
                              options.speeds.size() * loads.size()));
    return ExitCode::kDone;
  }
  std::vector<LogProtocol> protocols;
  for (const double speed : options.speeds) {
    for (const double load : loads) {
      LogProtocol& protocol =
          protocols.emplace_back(LogProtocol{speed, load, foreseeChange(evidence, protocolOf(speed, load))});
      protocol.beyond = beyondLimits(protocol.foreseen, options.limits);
    }
  }
  const LogProtocol& best = bestOf(protocols);
  session.begin(options.of.common.seed.value_or(0));
  session.directory().write("predictions.csv", predictionsCsv(best.foreseen, evidence));
  session.directory().write("next_log.csv", nextLogCsv(evidence, protocolOf(best.speed, best.load)));
  const Json result = toJson(protocols, evidence);
  session.finish(result, separationText(result));
  return ExitCode::kDone;
}

ExitCode separateArms(const SeparateOptions& options, Session& session) {
  const PoseEvidence evidence = readPoseEvidence(options.of.run, session);
  const SeparationOptions separation{options.candidates, options.count, options.of.common.seed.value_or(1),
                                     options.limits.tension};
  if (options.of.common.dry_run) {
    session.print(fmt::format("would choose {} of {} commands to tell {} models apart; nothing was written\n",
                              separation.poses, separation.candidates, evidence.candidates.size()));
    return ExitCode::kDone;
  }
  session.begin(separation.seed);
  const PoseSeparation found = separatePoses(evidence, separation);
  session.directory().write("next_poses.csv", nextPosesCsv(found, evidence.given));
  const Json result = toJson(found, evidence);
  session.finish(result, separationText(result));
  return ExitCode::kDone;
}

ExitCode separateMotionSets(const SeparateOptions& options, Session& session) {
  const MotionEvidence evidence = readMotionEvidence(options.of.run, session);
  if (options.of.common.dry_run) {
    session.print(fmt::format("would ask {} models for {} motions; nothing was written\n", evidence.candidates.size(),
                              options.speeds.size() * evidence.profile.size()));
    return ExitCode::kDone;
  }
  session.begin(options.of.common.seed.value_or(0));
  std::optional<Progress> progress(std::in_place, "design:", 100, options.of.common.quiet, Progress::Unit::kPercent);
  const MotionSeparation found =
      separateMotions(evidence, options.speeds, options.count, options.limits,
                      [&](double done) { progress->update(static_cast<std::size_t>(100.0 * done)); });
  for (const MotionProtocol& protocol : found.protocols) {
    if (protocol.chosen == 0) continue;
    session.directory().write(nextMotionFile(protocol.chosen),
                              commandsCsv(protocol.motion.commands, evidence.given.poseLayout()));
  }
  progress.reset();  // the result stands below its line
  const Json result = toJson(found, evidence);
  session.finish(result, separationText(result));
  return ExitCode::kDone;
}

}  // namespace

ExitCode designSeparation(const SeparateOptions& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("design", options.of.common, argv);
  requireCandidates(options.of.run);
  if (holdsCandidates(options.of.run, kLogCandidates)) {
    refuseOptions(app, {"--candidates", "--count", "--max-tension-N"},
                  "with a diagnosis of a log, expected it with one of poses");
    return separateLogs(options, session, app);
  }
  if (holdsCandidates(options.of.run, kMotionCandidates)) {
    refuseOptions(app, {"--candidates", "--loads"}, "with a diagnosis of motions, expected --speeds and --count");
    return separateMotionSets(options, session);
  }
  refuseOptions(app, {"--speeds", "--loads", "--max-current-A", "--max-duration-s"},
                "with a diagnosis of poses, expected it with one of a log");
  return separateArms(options, session);
}

}  // namespace simgap
