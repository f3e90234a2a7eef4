#include <fmt/format.h>

#include <optional>

#include "cli/inputs.h"
#include "cli/log_intervention.h"
#include "cli/motion_commands.h"
#include "simgap/core/progress.h"
#include "simgap/report/diagnosis/candidate_files.h"
#include "simgap/report/diagnosis/intervention_report.h"
#include "simgap/report/diagnosis/motion_intervention_report.h"

namespace simgap {

MotionEvidence readMotionEvidence(const std::filesystem::path& run, Session& session) {
  const std::filesystem::path folder = run / kCandidateFolder;
  const std::string list_file = (folder / kCandidateList).string();
  MotionEvidence evidence;
  evidence.given = readArmFile(session, "given model", (folder / kGivenModel).string());
  evidence.config = readMotionConfig(session, (run / "config.resolved.yaml").string(), evidence.given);
  const MotionCandidateList list = MotionCandidateList::read(
      YamlNode::parse(session.read("candidates", list_file).content, list_file), evidence.given);
  const auto table = [&](const char* role, const std::string& name) {
    const std::string file = (folder / name).string();
    return CsvTable::parse(session.take(role, file), file);
  };
  evidence.reference = list.reference;
  evidence.noise = list.noise;
  for (const MotionCandidateList::Entry& entry : list.entries) {
    MotionCandidate& candidate = evidence.candidates.emplace_back(entry.candidate);
    candidate.model = readArmFile(session, "candidate", (folder / entry.file).string());
    candidate.covariance = readCovariance(table("covariance", covarianceFileName(evidence.candidates.size() - 1)));
  }
  for (const MotionCandidateList::Profile& profile : list.profile) {
    evidence.profile.push_back(
        {profile.name, readCommands(table("commands", profile.file), evidence.given, profile.linear)});
  }
  evidence.validate();
  return evidence;
}

ExitCode interveneOnMotions(const InterveneOptions& options, const std::vector<std::string>& argv) {
  Session session("intervene", options.common, argv);
  if (!options.poses.empty() || !options.log.empty() || !options.profile.empty() || !options.bench.empty()) {
    throw ConfigError("found --poses, --log, --profile or --bench with a diagnosis of motions, expected --motions");
  }
  if (options.motions.empty() && options.changes.empty()) {
    throw ConfigError(
        "found neither --change nor --motions, expected what may be done to the arm, or what was recorded");
  }
  if (!options.motions.empty()) requireOneChange(options, "--motions");
  const MotionEvidence evidence = readMotionEvidence(options.run, session);
  const auto read = [&](const YamlNode& node) { return ArmChanges::read(node, evidence.given); };
  const std::vector<ArmChanges> changes = readChangeFiles<ArmChanges>(options, session, "further motions", read);
  for (const ArmChanges& change : changes) evidence.require(change);
  std::optional<MotionSet> after;
  if (!options.motions.empty()) {
    after = readMotions(session, "motions", options.motions, evidence.given, options.table.skip_bad_rows,
                        evidence.config.motions.motion.restart);
    requireOtherFiles(session, "motions table", options.run);
  }
  if (options.common.dry_run) {
    session.print(fmt::format("would ask {} models for {} changes; nothing was written\n", evidence.candidates.size(),
                              changes.size()));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  std::optional<Progress> progress(std::in_place, "intervene:", 100, options.common.quiet, Progress::Unit::kPercent);
  const auto share = [&](std::size_t k) {  // of the change with this number
    return [&progress, k, n = changes.size()](double done) {
      progress->update(static_cast<std::size_t>(100.0 * (static_cast<double>(k) + done) / static_cast<double>(n)));
    };
  };
  Json result;
  if (after) {
    const MotionIntervention judged = judgeChange(evidence, changes.front(), *after, share(0));
    session.directory().write("predictions.csv", predictionsCsv(judged, evidence, *after));
    result = toJson(judged, evidence, changes.front(), *after);
  } else {
    std::vector<ForeseenChange> foreseen;
    for (std::size_t k = 0; k < changes.size(); ++k) {
      foreseen.push_back(foreseeChange(evidence, changes[k], evidence.profile, share(k)));
    }
    result = toJson(foreseen, evidence, changes);
  }
  progress.reset();  // the result stands below its line
  session.finish(result, interventionText(result));
  return ExitCode::kDone;
}

}  // namespace simgap
