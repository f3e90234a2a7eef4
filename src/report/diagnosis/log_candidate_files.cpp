#include <fmt/format.h>
#include <fmt/ranges.h>

#include "candidate_entries.h"
#include "simgap/report/diagnosis/candidate_files.h"

namespace simgap {
namespace {

std::string posteriorYaml(const LogPosterior& posterior) {
  std::string text = fmt::format("    log_odds: {}\n    variance: {}\n    freedom: {}\n    names: [",
                                 posterior.log_odds, posterior.variance, posterior.freedom);
  for (std::size_t i = 0; i < posterior.names.size(); ++i) text += (i > 0 ? ", " : "") + yamlText(posterior.names[i]);
  text += "]\n    covariance:\n";
  for (Eigen::Index i = 0; i < posterior.covariance.rows(); ++i) {
    const Eigen::VectorXd row = posterior.covariance.row(i);
    text += fmt::format("      - [{}]\n", fmt::join(row.data(), row.data() + row.size(), ", "));
  }
  return text;
}

LogPosterior posteriorOf(const YamlNode& node) {
  LogPosterior posterior;
  posterior.log_odds = node.at("log_odds").number();
  posterior.variance = node.at("variance").number(kPositive);
  posterior.freedom = node.at("freedom").number(Range{1.0, kInfinity, false, "a number >= 1"});
  for (const YamlNode& name : node.at("names").items()) posterior.names.push_back(name.text());
  const YamlNode covariance = node.at("covariance");
  const std::vector<YamlNode> rows = covariance.items();
  const auto n = std::ssize(posterior.names);
  if (std::ssize(rows) != n) covariance.fail(fmt::format("found {} rows, expected {}", rows.size(), n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::vector<YamlNode> row = rows[i].items();
    if (std::ssize(row) != n) covariance.fail(fmt::format("found a row of {} numbers, expected {}", row.size(), n));
    if (i == 0) posterior.covariance.resize(n, n);  // not before a row is as long as the names say
    for (Eigen::Index k = 0; k < n; ++k) posterior.covariance(i, k) = row[k].number();
  }
  return posterior;
}

}  // namespace

void writeLogCandidates(const LogDiagnosis& result, const FittedModel& given, const ActuatorModel& subject,
                        const PreparedLog& log, const LogSource& source, const std::string& log_csv,
                        const std::string& bench_yaml, std::optional<double> ratio, const RunDirectory& directory) {
  if (result.candidates.empty()) return;
  const auto write = [&](const std::string& name, const std::string& content) {
    directory.write(fmt::format("{}/{}", kCandidateFolder, name), content);
  };
  std::string list = fmt::format("format: {}\ncorrelation_s: {}\nbench: {}\n", kLogCandidates, result.correlation_s,
                                 !bench_yaml.empty());
  if (ratio) list += fmt::format("transmission_ratio: {}\n", *ratio);
  list += "candidates:\n";
  for (std::size_t c = 0; c < result.candidates.size(); ++c) {
    const auto& [candidate, fit] = result.candidates[c];
    const std::string file = candidateFileName(c, candidate.causes);
    write(file, writeFittedModel(refittedModel(given, subject, fit, log, source)));
    list +=
        fmt::format("  - file: {}\n    causes: {}\n    role: {}\n", file, yamlText(candidate.causes), candidate.role);
    list += posteriorYaml(candidate.posterior);
  }
  if (!bench_yaml.empty()) write(kGivenBench, bench_yaml);
  write(kGivenLog, log_csv);
  write(kCandidateList, list);
}

LogCandidateList LogCandidateList::read(const YamlNode& root) {
  static_cast<void>(root.at("format").oneOf({kLogCandidates}));
  LogCandidateList list;
  list.correlation_s = root.at("correlation_s").number(kNonNegative);
  list.has_bench = root.at("bench").boolean();
  if (const auto ratio = root.find("transmission_ratio")) list.ratio = ratio->number(kPositive);
  list.entries = readCandidateEntries<Entry>(root.at("candidates"), [](const YamlNode& node, LogCandidate& candidate) {
    candidate.posterior = posteriorOf(node);
  });
  root.expectAllRead();
  return list;
}

}  // namespace simgap
