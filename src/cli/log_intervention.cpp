#include "log_intervention.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "cli/inputs.h"
#include "simgap/report/diagnosis/candidate_files.h"
#include "simgap/report/diagnosis/intervention_report.h"
#include "simgap/report/diagnosis/log_intervention_report.h"
#include "simgap/report/html/result_files.h"

namespace simgap {
LogEvidence readLogEvidence(const InterveneOptions& options, Session& session) {
  const std::filesystem::path folder = options.run / kCandidateFolder;
  const std::string list_file = (folder / kCandidateList).string();
  const LogCandidateList list =
      LogCandidateList::read(YamlNode::parse(session.read("candidates", list_file).content, list_file));
  LogEvidence evidence;
  evidence.correlation_s = list.correlation_s;
  std::string bench = options.bench;
  if (bench.empty() && list.has_bench) bench = (folder / kGivenBench).string();
  evidence.bench = readRig(session, bench, list.ratio);
  for (const LogCandidateList::Entry& entry : list.entries) {
    evidence.candidates.push_back({entry.candidate, readModel(session, "candidate", (folder / entry.file).string())});
  }
  if (!options.log.empty()) return evidence;
  if (options.profile.empty()) {
    evidence.reference_file = (folder / kGivenLog).string();
    evidence.reference = session.take("log before", evidence.reference_file);
  } else {
    evidence.reference_file = options.profile;
    evidence.reference = logCsv(readLog(session, "profile", options.profile, options.table).table);
  }
  return evidence;
}

void requireOneChange(const InterveneOptions& options, const char* recorded) {
  if (options.changes.size() <= 1) return;
  throw ConfigError(fmt::format("found {} files of --change with {}, expected the one that was made",
                                options.changes.size(), recorded));
}

void requireOtherFiles(const Session& session, const std::string& role, const std::filesystem::path& run) {
  const Json before = ResultFiles(run).run().value("inputs", Json::array());
  for (const Input& input : session.inputs()) {
    if (input.role != role) continue;
    for (const Json& known : before) {
      if (known.value("sha256", "") != input.sha256) continue;
      throw DataError(
          fmt::format("{}: found what the diagnosis in {} has seen, expected another recording: what found a cause "
                      "does not confirm it",
                      input.file.string(), run.string()));
    }
  }
}

namespace {

constexpr double kMostSeen = 0.1;  // of the rows

/// A piece of the log that found a cause, or one that goes on where it ended, confirms nothing either.
void requireOtherRows(const CsvTable& after, const InterveneOptions& options, Session& session) {
  const std::string file = (options.run / kCandidateFolder / kGivenLog).string();
  const CsvTable before = CsvTable::parse(session.take("log before", file), file);
  const std::size_t seen = rowsInBoth(after, before);
  if (static_cast<double>(seen) <= kMostSeen * static_cast<double>(after.rows())) return;
  throw DataError(
      fmt::format("{}: found {} of {} rows that the diagnosis in {} has seen, expected another recording: "
                  "what found a cause does not confirm it",
                  options.log, seen, after.rows(), options.run.string()));
}

/// A log from afterwards is taken as it is: whether its load was doubled, nobody asks.
void warnOfUnusedSizes(const LogChanges& change) {
  for (const LogChange& part : change.changes) {
    if (!part.kind->shown_by_log) continue;
    spdlog::warn("{}: the log shows by itself what became of the {}: the number that is stated is not used",
                 change.name, part.kind->name);
  }
}

}  // namespace

ExitCode interveneOnLog(const InterveneOptions& options, const std::vector<std::string>& argv) {
  Session session("intervene", options.common, argv);
  if (!options.poses.empty() || !options.motions.empty()) {
    throw ConfigError("found --poses or --motions with a diagnosis of a log, expected --log");
  }
  if (!options.log.empty() && !options.profile.empty()) {
    throw ConfigError("found --profile with --log, expected it only where nothing was recorded yet");
  }
  if (!options.log.empty()) requireOneChange(options, "--log");
  const LogEvidence evidence = readLogEvidence(options, session);
  const std::vector<LogChanges> changes = readChangeFiles<LogChanges>(
      options, session, options.log.empty() ? "this motion" : "another motion", &LogChanges::read);
  std::optional<LogTable> after;
  if (!options.log.empty()) {
    after = readLog(session, "log", options.log, options.table);
    requireOtherFiles(session, "log", options.run);
    requireOtherRows(after->table, options, session);
    for (const std::string& sentence : after->summary()) spdlog::warn("{}", sentence);
    warnOfUnusedSizes(changes.front());
  }
  if (options.common.dry_run) {
    session.print(fmt::format("would ask {} models for {} changes; nothing was written\n", evidence.candidates.size(),
                              changes.size()));
    return ExitCode::kDone;
  }
  Json result;  // what the log or the bench cannot be asked is known before anything is written
  if (after) {
    const LogIntervention judged = judgeChange(evidence, changes.front(), after->table);
    session.begin(options.common.seed.value_or(0));
    session.directory().write("predictions.csv", predictionsCsv(judged, evidence));
    result = toJson(judged, evidence, changes.front());
  } else {
    std::vector<ForeseenLogChange> foreseen;
    for (const LogChanges& change : changes) foreseen.push_back(foreseeChange(evidence, change));
    session.begin(options.common.seed.value_or(0));
    session.directory().write("predictions.csv", predictionsCsv(foreseen[bestOf(foreseen)], evidence));
    result = toJson(foreseen, evidence, changes);
  }
  session.finish(result, interventionText(result));
  return ExitCode::kDone;
}

}  // namespace simgap
