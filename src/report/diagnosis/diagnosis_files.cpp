#include "cause_table.h"
#include "robot_says.h"
#include "simgap/core/csv.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/diagnosis/diagnosis_report.h"
#include "simgap/report/log_predictions.h"
#include "simgap/report/motions/motion_report.h"

namespace simgap {
namespace {

/// One file per channel that what is left depends on: its shape.
void writeLeftovers(const Diagnosis& diagnosis, const RunDirectory& directory) {
  for (const Leftover& left : diagnosis.unexplained) {
    CsvWriter csv({left.channel, "mean_residual", "ci95", "rows"});
    for (const EvidenceBin& b : diagnosis.evidence) {
      if (b.against != left.channel) continue;
      csv.add(b.center).add(b.after).add(b.after_ci95).add(static_cast<double>(b.rows)).endRow();
    }
    directory.write("residual_" + left.channel + ".csv", csv.text());
  }
}

void writeDiagnosisTables(const Diagnosis& diagnosis, const RunDirectory& directory) {
  directory.write("hypotheses.csv", hypothesesCsv(diagnosis));
  directory.write("evidence.csv", evidenceCsv(diagnosis));
  if (diagnosis.self_test) directory.write("confusion.csv", csvText(confusionTable(toJson(diagnosis))));
}

}  // namespace

void writeLogDiagnosis(const LogDiagnosis& result, const FittedModel& given, const ActuatorModel& subject,
                       const PreparedLog& log, const LogSource& source, const RunDirectory& directory) {
  if (result.predicted_after.size() == 0) return;
  const auto writeModel = [&](const char* name, const LogFit& fit) {
    directory.write(name, writeFittedModel(refittedModel(given, subject, fit, log, source)));
  };
  writeModel("baseline.yaml", result.baseline);
  writeModel("model.yaml", result.extended);
  directory.write("predictions.csv",
                  predictionsCsv(log, {{"before", &result.predicted_before}, {"after", &result.predicted_after}}));
  writeDiagnosisTables(result.diagnosis, directory);
  writeLeftovers(result.diagnosis, directory);
}

void writeMotionDiagnosis(const MotionDiagnosis& result, const RunDirectory& directory) {
  if (result.after.empty()) return;
  directory.write("baseline.yaml", writeArm(result.baseline));
  directory.write("model.yaml", writeArm(result.model));
  const PlayedSet before{"held out", "before", &result.held_out, &result.before},
      after{"held out", "with the causes", &result.held_out, &result.after};
  directory.write("residuals.csv", residualsCsv(result.layout, {before, after}));
  writeMotionScene(result, directory);
  writeDiagnosisTables(result.diagnosis, directory);
}

void writeRobotDiagnosis(const RobotDiagnosis& result, const RobotLog& log, const RunDirectory& directory) {
  if (result.after.size() == 0) return;
  if (result.extended) directory.write("model.yaml", writeRobotModel(*result.extended));
  directory.write("robot_predictions.csv", robotPredictionsCsv(result, log));
  writeDiagnosisTables(result.diagnosis, directory);
}

void writePoseDiagnosis(const PoseDiagnosis& result, const RunDirectory& directory) {
  directory.write("model.yaml", writeArm(result.model));
  directory.write("poses.csv", result.pose_errors);
  writeDiagnosisTables(result.diagnosis, directory);
}

}  // namespace simgap
