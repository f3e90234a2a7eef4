#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "cli/inputs.h"
#include "cli/motion_commands.h"
#include "simgap/cli/command.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/progress.h"
#include "simgap/report/poses/pose_report.h"
#include "simgap/simulate/arm_geometry.h"
#include "simgap/simulate/replay.h"

namespace simgap::commands::validate {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::string model, poses, motions, config;
  std::string evaluator = "bullet";
  std::optional<double> max_mje, max_rms;        ///< [deg]
  std::optional<double> max_mje_mm, max_rms_mm;  ///< of slides
  std::optional<double> settle;                  ///< [s]
};

constexpr double kPatience = 60.0;  // longest settling where nobody has said one [s]

ValidationResult judge(const Options& options, const ArmModel& model, const PoseSet& set,
                       const PoseProtocol& protocol) {
  ValidationResult result{model.poseLayout(), set, {}, {}};
  Progress progress("validate: pose", set.poses.size(), options.common.quiet);
  result.assessment = replayAll(*makeEvaluator(options.evaluator, protocol), model, set,
                                [&](std::size_t done) { progress.update(done); });
  for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
    const auto& [name, type] = result.layout.joints[j];
    const JointKind& kind = kindOf(type);
    const std::optional<double>& limit = kind.slides ? options.max_mje_mm : options.max_mje;
    if (!limit) continue;
    result.criteria.push_back(
        {fmt::format("mje_{} of {}", kind.error_unit, name), *limit, kind.shown(result.assessment.mje[j])});
  }
  return result;
}

void warn(const ArmModel& model, const ValidationResult& result) {
  const std::vector<PoseOutcome>& outcomes = result.assessment.outcomes;
  for (const std::string& cord : stretchedCords(outcomes, result.layout)) spdlog::warn("{}", cord);
  const std::string ambiguous = otherEquilibria(model, result.set, outcomes);
  if (!ambiguous.empty()) spdlog::warn("{}", ambiguous);
}

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  Session session("validate", options.common, argv);
  const ArmModel model = readArmFile(session, "model", options.model);
  const PoseSet set = readPoses(session, "poses", options.poses, model, options.table.csv());
  PoseProtocol protocol = options.config.empty() ? PoseProtocol{} : readConfig(session, options.config).protocol;
  // Steady poses end their settling by themselves: a longer limit gives slow arms time and changes no other outcome.
  protocol.settle = options.settle.value_or(options.config.empty() ? kPatience : protocol.settle);
  if (options.common.dry_run) {
    session.print(fmt::format("would replay {} poses of {} on {}; nothing was written\n", set.poses.size(), set.file,
                              model.name));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  session.directory().write("config.resolved.yaml", "protocol:\n" + protocol.toYaml("  "));
  const ValidationResult result = judge(options, model, set, protocol);
  warn(model, result);
  session.directory().write("errors.csv", errorsCsv(result));
  const ReplayedSet replay{"replayed", "simulated", model, set, result.assessment.outcomes};
  writeArmGeometry({&replay, 1}, session.directory());
  if (result.assessment.valid < set.poses.size()) {
    const std::string reason = describeInvalid(result.assessment, set, result.layout, options.evaluator);
    session.finish(toJson(result), terminalTable(result), "failed: " + reason);
    throw NumericsError(reason);
  }
  session.finish(toJson(result), terminalTable(result));
  return std::ranges::all_of(result.criteria, &Criterion::pass) ? ExitCode::kDone : ExitCode::kCriterionFailed;
}

/// Poses or motions: each has options of its own.
ExitCode runEither(const Options& options, const CLI::App& app, const std::vector<std::string>& argv) {
  const bool moves = !options.motions.empty();
  if (options.poses.empty() != moves) throw ConfigError("validate needs either --poses or --motions (see --help)");
  if (moves) {
    refuseOptions(app, {"--evaluator", "--max-mje", "--max-mje-mm", "--settle-s", "--map"},
                  "with --motions, expected it with --poses");
  } else {
    refuseOptions(app, {"--max-rms", "--max-rms-mm"}, "with --poses, expected it with --motions");
  }
  if (!moves) return run(options, argv);
  return validateMotions({options.common, options.table.skip_bad_rows, options.model, options.motions, options.config,
                          options.max_rms, options.max_rms_mm},
                         argv);
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("MODEL", options->model, "arm model (YAML)")->required();
  app.add_option("--poses", options->poses, "recorded poses (CSV)");
  app.add_option("--motions", options->motions, "recorded motions instead (YAML): errors over time");
  app.add_option("--config", options->config, "calibration config whose protocol is used (default: the paper's)");
  app.add_option("--max-rms", options->max_rms, "of motions: exit 1 when a joint's rms exceeds this, per axis [deg]")
      ->check(positiveNumber());
  app.add_option("--max-rms-mm", options->max_rms_mm, "the same of joints that slide [mm]")->check(positiveNumber());
  app.add_option("--evaluator", options->evaluator, "bullet: simulate; equilibrium: minimise the potential energy")
      ->check(CLI::IsMember({"bullet", "equilibrium"}));
  app.add_option("--settle-s", options->settle,
                 "longest time that joints may take to come to rest (default: the config's; without one 60) [s]")
      ->check(positiveNumber());
  app.add_option("--max-mje", options->max_mje, "exit 1 when a joint's mean error exceeds this [deg]")
      ->check(positiveNumber());
  app.add_option("--max-mje-mm", options->max_mje_mm, "the same of joints that slide [mm]")->check(positiveNumber());
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] { return runEither(*options, app, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"validate", "errors of a model on recorded poses, or over recorded motions",
                    "  simgap calibrate data/arm/arm.yaml \\\n"
                    "    --poses data/arm/poses_calibration.csv --optimizer lm -o runs/arm\n"
                    "  simgap validate runs/arm/model.yaml \\\n"
                    "    --poses data/arm/poses_validation.csv --max-mje 5 -o runs/validation\n"
                    "  simgap validate data/motions/arm.yaml \\\n"
                    "    --motions data/motions/open-none/validation/motions.yaml -o runs/motions",
                    define};

}  // namespace simgap::commands::validate
