#include <fmt/format.h>

#include <algorithm>

#include "cli/inputs.h"
#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/diagnosis/candidate_files.h"
#include "simgap/report/diagnosis/intervention_report.h"

namespace simgap::commands::intervene {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::filesystem::path run;
  std::vector<std::string> changes;
  std::string after;
};

/// What the diagnosis left in its folder of candidates.
PoseEvidence readEvidence(const Options& options, Session& session) {
  const std::filesystem::path folder = options.run / kCandidateFolder;
  if (!std::filesystem::is_directory(folder)) {
    throw ConfigError(fmt::format("{}: found no folder {}, expected the result of simgap diagnose --poses",
                                  options.run.string(), kCandidateFolder));
  }
  const std::string list_file = (folder / kCandidateList).string();
  const CandidateList list =
      CandidateList::read(YamlNode::parse(session.read("candidates", list_file).content, list_file));
  PoseEvidence evidence;
  evidence.given = readArmFile(session, "given model", (folder / kGivenModel).string());
  evidence.excess = list.excess;
  const std::filesystem::path config = options.run / "config.resolved.yaml";
  const CalibrationConfig settings = readConfig(session, config.string(), &evidence.given);
  evidence.parameters = settings.parameters;
  evidence.noise = settings.noise;
  const PoseSet poses = readPoses(session, "poses before", (folder / kGivenPoses).string(), evidence.given, {});
  for (const std::string& name : list.used) {
    const auto pose = std::ranges::find(poses.poses, name, &Pose::name);
    if (pose == poses.poses.end()) {
      throw DataError(fmt::format("{}: found no pose {}, which {} says was used", poses.file, name, list_file));
    }
    evidence.poses.push_back(*pose);
  }
  for (const CandidateList::Entry& entry : list.entries) {
    evidence.candidates.push_back(entry.candidate);
    evidence.candidates.back().model = readArmFile(session, "candidate", (folder / entry.file).string());
  }
  evidence.threads = options.common.threads;
  return evidence;
}

std::vector<ArmChanges> readChanges(const Options& options, Session& session, const ArmModel& model) {
  std::vector<ArmChanges> changes;
  for (const std::string& file : options.changes) {
    changes.push_back(ArmChanges::read(YamlNode::parse(session.read("change", file).content, file), model));
    if (changes.back().name.empty()) changes.back().name = std::filesystem::path(file).stem().string();
  }
  return changes;
}

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  Session session("intervene", options.common, argv);
  if (!options.after.empty() && options.changes.size() != 1) {
    throw ConfigError(
        fmt::format("found {} files of --change with --poses, expected the one that was made", options.changes.size()));
  }
  const PoseEvidence evidence = readEvidence(options, session);
  const std::vector<ArmChanges> changes = readChanges(options, session, evidence.given);
  PoseSet after;
  if (!options.after.empty()) after = readPoses(session, "poses", options.after, evidence.given, options.table.csv());
  if (options.common.dry_run) {
    session.print(fmt::format("would ask {} models for {} changes; nothing was written\n", evidence.candidates.size(),
                              changes.size()));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  Json result;
  if (options.after.empty()) {
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
  app.add_option("RUN", options->run, "result directory of diagnose --poses")->required();
  app.add_option("--change", options->changes, "what was done to the arm, or may be (YAML); without --poses several")
      ->required();
  app.add_option("--poses", options->after, "poses recorded after the change (CSV)");
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
                    "    -o runs/weight",
                    define};

}  // namespace simgap::commands::intervene
