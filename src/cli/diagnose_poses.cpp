#include "diagnose_poses.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <charconv>

#include "pose_inputs.h"
#include "simgap/core/error.h"
#include "simgap/core/progress.h"
#include "simgap/report/diagnosis/diagnosis_report.h"

namespace simgap {
namespace {

double readFraction(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw ConfigError(fmt::format("--holdout: found '{}', expected a fraction of the poses", text));
  }
  return value;
}

}  // namespace

ExitCode diagnosePoseFile(Session& session, const PoseDiagnosisInputs& inputs, const CsvOptions& csv,
                          const CommonOptions& common, PoseDiagnosisOptions options) {
  if (!inputs.holdout.empty()) options.holdout = readFraction(inputs.holdout);
  options.validate();
  const ArmModel model = parseArm(session.read("model", inputs.model));
  const PoseSet set = parsePoses(session.read("poses", inputs.poses), model, csv);
  const CalibrationConfig config = parseConfig(readConfig(session, inputs.config));
  if (common.dry_run) {
    fmt::print("would diagnose {} on {} poses of {}; nothing was written\n", model.name, set.poses.size(), set.file);
    return ExitCode::kDone;
  }
  session.begin(options.seed);
  const RunDirectory& directory = session.directory();
  directory.write("config.resolved.yaml", config.toYaml());
  Progress progress("diagnose, %", 100, common.quiet);
  const PoseDiagnosis result = diagnosePoses(
      model, set, config.parameters, config.noise, options,
      [&](const std::string& what, double done) { progress.update(static_cast<std::size_t>(100.0 * done), what); });
  const Diagnosis& diagnosis = result.diagnosis;
  for (const std::string& warning : diagnosis.warnings) spdlog::warn("{}", warning);
  directory.write("model.yaml", writeArm(result.model));
  directory.write("poses.csv", result.pose_errors);
  directory.write("hypotheses.csv", hypothesesCsv(diagnosis));
  directory.write("evidence.csv", evidenceCsv(diagnosis));
  if (diagnosis.self_test) directory.write("confusion.csv", confusionCsv(*diagnosis.self_test));
  session.finish(toJson(diagnosis), terminalTable(diagnosis));
  return ExitCode::kDone;
}

}  // namespace simgap
