#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "../fit_options.h"
#include "simgap/cli/command.h"
#include "simgap/core/csv.h"
#include "simgap/fit/pam_fit.h"
#include "simgap/report/charts.h"

namespace simgap::commands {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  FitOptions fit;
  std::string log, curves;
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

void addCharts(const std::vector<Candidate>& candidates, const PamLog& log, Page& page) {
  std::vector<double> levels(log.pressure);
  std::ranges::sort(levels);
  std::vector<Curve> curves{{"measured", {}, {}, true}};
  const std::size_t stride = std::max<std::size_t>(1, log.rows() / 1500);
  for (std::size_t i = 0; i < log.rows(); i += stride) {
    curves[0].x.push_back(log.contraction[i]);
    curves[0].y.push_back(log.force[i]);
  }
  const auto [low, high] = std::ranges::minmax(log.contraction);
  for (const Candidate& c : candidates) {
    Pam muscle = c.fit.muscle();
    muscle.lowest = -1.0, muscle.highest = 1.0;
    for (const double q : {0.4, 0.7, 1.0}) {
      const double pressure = levels[static_cast<std::size_t>(q * static_cast<double>(levels.size() - 1))];
      Curve curve{fmt::format("{} at {:.0f} kPa", c.name, 1e-3 * pressure), {}, {}, false};
      for (int i = 0; i <= 60; ++i) {
        const double eps = low + (high - low) * i / 60.0;
        if (const auto f = muscle.force(pressure, eps)) {
          curve.x.push_back(eps);
          curve.y.push_back(*f);
        }
      }
      curves.push_back(curve);
    }
  }
  page.charts.push_back({"Force over apparent contraction", curveChart(curves, "apparent contraction", "force [N]")});
  std::vector<Curve> errors;
  for (const Candidate& c : candidates) {
    Pam muscle = c.fit.muscle();
    muscle.lowest = -1.0, muscle.highest = 1.0;
    Curve error{c.name, {}, {}, true};
    for (std::size_t i = 0; i < log.rows(); i += stride) {
      const auto f = muscle.force(log.pressure[i], log.contraction[i]);
      if (!f) continue;
      error.x.push_back(log.force[i]);
      error.y.push_back(*f - log.force[i]);
    }
    errors.push_back(error);
  }
  page.charts.push_back({"Error over force", curveChart(errors, "measured force [N]", "predicted - measured [N]")});
}

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("fit-pam", options.common, argv);
  std::optional<PamFit> maker;
  const std::vector<FitParameter> known = {{"a", ""}, {"b", ""}, {"c", ""}, {"k", ""}};
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
  Page page = makePage(summary);
  addCharts(candidates, log, page);
  session.finish(toJson(summary), page, terminalTable(summary));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("LOG", options->log, "log of the muscle (CSV: pressure_Pa, contraction, force_N)")->required();
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
