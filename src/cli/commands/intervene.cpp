#include <fmt/format.h>

#include <algorithm>

#include "cli/inputs.h"
#include "cli/log_intervention.h"
#include "cli/motion_commands.h"
#include "cli/pose_evidence.h"
#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/diagnosis/candidate_files.h"
#include "simgap/report/diagnosis/intervention_report.h"

namespace simgap::commands::intervene {
namespace {

using Options = InterveneOptions;

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  if (holdsCandidates(options.run, kLogCandidates)) return interveneOnLog(options, argv);
  if (holdsCandidates(options.run, kMotionCandidates)) return interveneOnMotions(options, argv);
  Session session("intervene", options.common, argv);
  requireCandidates(options.run);
  if (!options.motions.empty()) throw ConfigError("found --motions with a diagnosis of poses, expected --poses");
  if (!options.log.empty() || !options.profile.empty() || !options.bench.empty()) {
    throw ConfigError("found --log, --profile or --bench with a diagnosis of poses, expected --poses");
  }
  if (options.poses.empty() && options.changes.empty()) {
    throw ConfigError("found neither --change nor --poses, expected what may be done to the arm, or what was recorded");
  }
  if (!options.poses.empty()) requireOneChange(options, "--poses");
  const PoseEvidence evidence = readPoseEvidence(options.run, session);
  const auto read = [&](const YamlNode& node) { return ArmChanges::read(node, evidence.given); };
  const std::vector<ArmChanges> changes = readChangeFiles<ArmChanges>(options, session, "further poses", read);
  PoseSet after;
  if (!options.poses.empty()) after = readPoses(session, "poses", options.poses, evidence.given, options.table.csv());
  if (!options.poses.empty()) {
    requireOtherPoses(after, {"the diagnosis", evidence.poses}, "poses that found a cause do not confirm it");
  }
  if (options.common.dry_run) {
    session.print(fmt::format("would ask {} models for {} changes; nothing was written\n", evidence.candidates.size(),
                              changes.size()));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  Json result;
  if (options.poses.empty()) {
    std::vector<ForeseenChange> foreseen;
    for (const ArmChanges& change : changes) foreseen.push_back(foreseeChange(evidence, change));
    result = toJson(foreseen, evidence, changes);
  } else {
    const Intervention judged = judgeChange(evidence, changes.front(), after);
    session.directory().write("predictions.csv", predictionsCsv(judged, evidence, after));
    result = toJson(judged, evidence, changes.front());
  }
  session.finish(result, interventionText(result));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("RUN", options->run, "result directory of diagnose")->required();
  app.add_option("--change", options->changes,
                 "what was done to the arm or the bench, or may be (YAML); several where nothing was recorded yet");
  app.add_option("--poses", options->poses, "poses recorded after the change (CSV); without --change further ones");
  app.add_option("--motions", options->motions,
                 "motions recorded after the change (YAML); without --change further ones");
  app.add_option("--log", options->log,
                 "log recorded after the change (CSV); without --change only the motion differs");
  app.add_option("--profile", options->profile, "motion and load to foresee a log for (CSV; default: the log before)");
  app.add_option("--bench", options->bench, "another rig than that of the diagnosis (YAML)");
  options->table.add(app);
  options->common.add(app);
  return [options, argv] { return run(*options, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"intervene", "a change made on purpose: which cause predicts what comes of it",
                    "  simgap diagnose data/arm-dense/arm.yaml \\\n"
                    "    --poses data/arm-dense/poses_calibration.csv -o runs/diagnosis-arm\n"
                    "  simgap intervene runs/diagnosis-arm --change data/arm-dense/weight.yaml \\\n"
                    "    -o runs/weight\n"
                    "  simgap diagnose classic --log data/logs/bend-friction.csv.gz \\\n"
                    "    -o runs/diagnosis\n"
                    "  simgap intervene runs/diagnosis --change data/logs/straight-cable.yaml \\\n"
                    "    -o runs/straight",
                    define};

}  // namespace simgap::commands::intervene
