#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <optional>

#include "cli/inputs.h"
#include "cli/motion_commands.h"
#include "simgap/core/progress.h"
#include "simgap/report/diagnosis/candidate_files.h"
#include "simgap/report/diagnosis/diagnosis_report.h"

namespace simgap {

ExitCode diagnoseMotionSet(const MotionDiagnoseOptions& options, Session& session) {
  options.diagnose.validate();
  const ArmModel model = readArmFile(session, "model", options.model);
  const MotionCalibrationConfig config = readMotionConfig(session, options.config, model);
  const double restart = config.motions.motion.restart;
  const MotionSet set = readMotions(session, "motions", options.motions, model, options.skip_bad_rows, restart);
  std::optional<MotionSet> judging;
  if (!options.validation_motions.empty()) {
    judging =
        readOtherMotions(session, options.validation_motions, options.motions, model, options.skip_bad_rows, restart);
  }
  if (options.common.dry_run) {
    session.print(fmt::format(
        "would diagnose {} on {} motions of {}{}; nothing was written\n", model.name, set.motions.size(), set.file,
        judging ? fmt::format(", judged by {} of {}", judging->motions.size(), judging->file) : ""));
    return ExitCode::kDone;
  }
  session.begin(options.diagnose.seed);
  session.directory().write("config.resolved.yaml", config.toYaml());
  std::optional<Progress> progress(std::in_place, "diagnose:", 100, options.common.quiet, Progress::Unit::kPercent);
  const MotionDiagnosis result = diagnoseMotions(
      model, set, judging ? &*judging : nullptr, config, options.diagnose,
      [&](const std::string& what, double done) { progress->update(static_cast<std::size_t>(100.0 * done), what); });
  writeMotionDiagnosis(result, session.directory());
  writeMotionCandidates(result, model, session.directory());
  progress.reset();  // the result stands below its line
  for (const std::string& warning : result.diagnosis.warnings) spdlog::warn("{}", warning);
  session.finish(toJson(result), terminalTable(result));
  return ExitCode::kDone;
}

}  // namespace simgap
