#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cli/drive_subject.h"
#include "cli/fit_options.h"
#include "simgap/cli/command.h"
#include "simgap/core/csv.h"
#include "simgap/fit/actuators/pam_fit.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap::commands {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  FitOptions fit;
  std::string log, curves, model;
  bool tied = false;
};

/// With and without the tendon's spring, on the same rows.
struct Candidate {
  std::string name;
  PamFit fit;
  std::optional<double> heldout;
};

std::vector<Block> blocksOf(const PamLog& log, double seconds) {
  return log.time.empty() ? splitRows(log.session, std::max<std::size_t>(1, log.rows() / 50))
                          : splitBlocks(log.time, log.session, seconds);
}

Candidate fitCandidate(const std::string& name, const PamLog& log, const PamFitOptions& options,
                       const std::vector<bool>& kept, bool final_on_all) {
  const bool any = std::ranges::count(kept, false) > 0;
  Candidate candidate{name, fitPam(log, options, kept), std::nullopt};
  if (any) {
    std::vector<bool> held = kept;
    held.flip();
    candidate.heldout = meanSquaredError(candidate.fit, log, held);
    if (final_on_all) candidate.fit = fitPam(log, options);
  }
  return candidate;
}

std::vector<Candidate> fitBoth(const Options& options, const PamLog& log, const std::optional<PamFit>& maker,
                               const std::vector<bool>& kept) {
  PamFitOptions plain{false, options.tied, options.fit.fixed(), options.fit.parameterBounds()};
  if (maker) {
    for (std::size_t i = 0; i < 3; ++i) plain.fixed.try_emplace(std::string(1, "abc"[i]), maker->theta[i]);
  }
  PamFitOptions spring = plain;
  spring.spring = !plain.fixed.contains("k");
  const bool final_on_all = options.fit.holdout.empty();
  std::vector<Candidate> candidates;
  if (spring.spring) candidates.push_back(fitCandidate("no-spring", log, plain, kept, final_on_all));
  candidates.push_back(fitCandidate("spring", log, spring, kept, final_on_all));
  return candidates;
}

FitSummary summarise(const std::vector<Candidate>& candidates, std::size_t best, const std::string& heldout) {
  const Candidate& chosen = candidates[best];
  FitSummary summary;
  summary.command = "fit-pam";
  summary.model = chosen.name;
  summary.target = "force";
  summary.target_unit = "N";
  summary.uncertainty = chosen.fit.uncertainty;
  summary.mse = chosen.fit.mse;
  summary.mse_heldout = chosen.heldout;
  summary.heldout = heldout;
  summary.n = chosen.fit.n;
  summary.starts = chosen.fit.starts;
  summary.distinct_minima = chosen.fit.distinct_minima;
  summary.warnings = chosen.fit.warnings;
  const double n = chosen.fit.uncertainty.n_effective;
  for (const Candidate& c : candidates) {
    summary.comparison.push_back({c.name, c.fit.parameters, c.fit.mse, c.heldout,
                                  n * std::log(c.fit.mse) + static_cast<double>(c.fit.parameters) * std::log(n)});
  }
  if (const auto geometry = geometryOf(chosen.fit.theta[0], chosen.fit.theta[2])) {
    summary.facts.emplace_back("geometry of a and c",
                               fmt::format("diameter {:.1f} mm, braid angle {:.1f} deg (002 eq. 12)",
                                           1e3 * geometry->diameter, geometry->angle * 180.0 / std::numbers::pi));
  }
  return summary;
}

/// Every so many rows are shown.
std::size_t shownStride(const PamLog& log) { return std::max<std::size_t>(1, log.rows() / 1500); }

Pam unboundedMuscle(const Candidate& candidate) {
  Pam muscle = candidate.fit.muscle();
  muscle.lowest = -1.0, muscle.highest = 1.0;
  return muscle;
}

/// Measured and predicted force over contraction: some rows of the log, and each candidate at three pressures.
std::string forcesCsv(const std::vector<Candidate>& candidates, const PamLog& log) {
  CsvWriter csv({"series", "contraction", "force_N"});
  std::vector<double> levels(log.pressure);
  std::ranges::sort(levels);
  for (std::size_t i = 0; i < log.rows(); i += shownStride(log)) {
    csv.add("measured").add(log.contraction[i]).add(log.force[i]).endRow();
  }
  const auto [low, high] = std::ranges::minmax(log.contraction);
  for (const Candidate& c : candidates) {
    const Pam muscle = unboundedMuscle(c);
    for (const double q : {0.4, 0.7, 1.0}) {
      const double pressure = levels[static_cast<std::size_t>(q * static_cast<double>(levels.size() - 1))];
      for (int i = 0; i <= 60; ++i) {
        const double eps = low + (high - low) * i / 60.0;
        const auto f = muscle.force(pressure, eps);
        if (f) csv.add(fmt::format("{} at {:.0f} kPa", c.name, 1e-3 * pressure)).add(eps).add(*f).endRow();
      }
    }
  }
  return csv.text();
}

std::string errorsCsv(const std::vector<Candidate>& candidates, const PamLog& log) {
  CsvWriter csv({"series", "force_N", "error_N"});
  for (const Candidate& c : candidates) {
    const Pam muscle = unboundedMuscle(c);
    for (std::size_t i = 0; i < log.rows(); i += shownStride(log)) {
      const auto f = muscle.force(log.pressure[i], log.contraction[i]);
      if (f) csv.add(c.name).add(log.force[i]).add(*f - log.force[i]).endRow();
    }
  }
  return csv.text();
}

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("fit-pam", options.common, argv);
  if (!options.model.empty()) {
    return fitExtended({"fit-pam", options.model, options.log, {}, options.table.csv()}, session, options.common, app);
  }
  std::optional<PamFit> maker;
  const std::vector<ParameterSpec> known = {{"a", ""}, {"b", ""}, {"c", ""}, {"k", ""}};
  requireKnownParameters(options.fit, known);
  if (!options.curves.empty()) {
    const PamLog curves = readPamLog(session.readTable("curves", options.curves, options.table.csv()));
    maker = fitPam(curves, {false, options.tied, {}, {}});
  }
  Holdout holdout;
  PamLog log;
  {
    const CsvTable table = session.readTable("log", options.log, options.table.csv());
    log = readPamLog(table);
    holdout = readHoldout(options.fit.holdout, table);
  }
  std::string words = holdout.words;
  if (!holdout.any()) {
    holdout.fraction = 0.2;
    words = "20 % of the blocks, before the final fit to all rows";
  }
  std::vector<std::size_t> rows(log.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  const std::vector<Block> blocks =
      blocksOf(log, options.fit.blockSeconds(log.time.empty() ? 0.0 : log.time.back() - log.time.front()));
  std::vector<bool> kept(log.rows(), true);
  if (blocks.size() >= 5 || !options.fit.holdout.empty()) {
    kept = heldOutRows(holdout, blocks, rows);
    kept.flip();
  }
  const std::vector<Candidate> candidates = fitBoth(options, log, maker, kept);
  std::size_t best = candidates.size() - 1;
  const auto judge = [](const Candidate& c) { return c.heldout.value_or(c.fit.mse); };
  if (judge(candidates.front()) < judge(candidates[best])) best = 0;
  FitSummary summary = summarise(candidates, best, words);
  if (maker)
    summary.facts.emplace_back("a, b, c",
                               fmt::format("from {} (RMS {:.3g} N there)", options.curves, std::sqrt(maker->mse)));
  for (const std::string& file : options.fit.validate) {
    const PamLog other = readPamLog(session.readTable("validation", file, options.table.csv()));
    summary.transfer.push_back({file, other.rows(), meanSquaredError(candidates[best].fit, other, {})});
  }
  if (options.common.dry_run) {
    fmt::print("would fit a muscle to {} rows of {}; nothing was written\n", log.rows(), options.log);
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  FittedModel model = fittedModel("pam", candidates[best].name, candidates[best].fit.uncertainty);
  const auto [low, high] = std::ranges::minmax(log.contraction);
  model.settings = {{"contraction_min", fmt::format("{}", low)}, {"contraction_max", fmt::format("{}", high)}};
  model.data_file = log.file;
  model.data_sha256 = session.inputs()[maker ? 1 : 0].sha256;
  model.data_rows = log.rows();
  session.directory().write("model.yaml", writeFittedModel(model));
  session.directory().write("parameters.csv", parametersCsv(summary));
  session.directory().write("correlation.csv", correlationCsv(summary));
  session.directory().write("forces.csv", forcesCsv(candidates, log));
  session.directory().write("errors.csv", errorsCsv(candidates, log));
  session.finish(toJson(summary), terminalTable(summary));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("LOG", options->log, "log of the muscle (CSV: pressure_Pa, contraction, force_N)")->required();
  app.add_option("--model", options->model,
                 "a diagnosed muscle (YAML): its equation and its extensions are fitted together");
  app.add_option("--curves", options->curves,
                 "the maker's curves (CSV, the same columns): a, b, c come from them, k from LOG, as in the paper");
  app.add_flag("--tied", options->tied, "b = -2a, as the muscle's geometry demands");
  return defineFit(options, app, argv, run);
}

}  // namespace

extern const Command fit_pam;
const Command fit_pam{"fit-pam", "force model of a pneumatic muscle, with and without its tendon's spring",
                      "  simgap fit-pam rig.csv --curves maker.csv -o runs/pam", define};

}  // namespace simgap::commands
