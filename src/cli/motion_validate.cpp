#include <fmt/format.h>

#include <algorithm>

#include "cli/inputs.h"
#include "cli/motion_commands.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/report/motions/motion_report.h"

namespace simgap {
namespace {

MotionCalibrationConfig motionOptionsOf(Session& session, const std::string& file) {
  if (file.empty()) return {};
  return MotionCalibrationConfig::read(YamlNode::parse(session.read("config", file).content, file));
}

/// Why not all motions could be played; empty when they could.
std::string motionFailures(const MotionValidationResult& result, const MotionOptions& options) {
  std::size_t failed = 0;
  std::string first;
  for (std::size_t m = 0; m < result.played.size(); ++m) {
    if (result.played[m].valid) continue;
    if (failed++ == 0) {
      first =
          fmt::format("{}: {}", result.set.motions[m].name, describeFailure(result.played[m], result.layout, options));
    }
  }
  return failed == 0 ? "" : fmt::format("{} of {} motions cannot be played: {}", failed, result.played.size(), first);
}

}  // namespace

ExitCode validateMotions(const MotionValidateOptions& options, const std::vector<std::string>& argv) {
  Session session("validate", options.common, argv);
  const ArmModel model = readArmFile(session, "model", options.model);
  const MotionCalibrationConfig config = motionOptionsOf(session, options.config);
  const MotionOptions& played_by = config.motions.motion;
  const MotionSet set =
      readMotions(session, "motions", options.motions, model, options.skip_bad_rows, played_by.restart);
  if (options.common.dry_run) {
    session.print(fmt::format("would play {} motions of {} to {} in steps of {:g} s; nothing was written\n",
                              set.motions.size(), set.file, model.name, played_by.rollout.step));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  session.directory().write("config.resolved.yaml", "motions:\n" + played_by.toYaml("  "));
  const PoseLayout layout = model.poseLayout();
  MotionValidationResult result{layout, set, playAll(model, set.motions, played_by), {}, {}, {}};
  result.noise = estimateNoise(set.motions, layout, config.motions.noise);
  result.rms = motionRms(set.motions, result.played, layout);
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const JointKind& kind = kindOf(layout.joints[j].type);
    const auto& limit = kind.slides ? options.max_rms_mm : options.max_rms;
    if (!limit) continue;
    result.criteria.push_back({fmt::format("rms_{} of {}", kind.error_unit, layout.joints[j].name), *limit,
                               kind.shown(result.rms.joints[j])});
  }
  session.directory().write("errors.csv", motionErrorsCsv(result));
  const PlayedSet shown{"", "", &set, &result.played};
  session.directory().write("residuals.csv", residualsCsv(layout, {shown}));
  const std::string failure = motionFailures(result, played_by);
  session.finish(toJson(result), terminalTable(result), failure.empty() ? "done" : "failed: " + failure);
  if (!failure.empty()) throw NumericsError(failure);
  return std::ranges::all_of(result.criteria, &Criterion::pass) ? ExitCode::kDone : ExitCode::kCriterionFailed;
}

}  // namespace simgap
