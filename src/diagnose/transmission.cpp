#include "transmission.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "log_causes.h"
#include "simgap/fit/uncertainty.h"

namespace simgap {
namespace {

constexpr double kDerived = 1e-9;  // of the joint's range: one angle was worked out from the other

bool isWanted(const LogDiagnosisOptions& options, std::string_view name) {
  return options.effects.empty() || std::ranges::find(options.effects, name) != options.effects.end();
}

}  // namespace

void addTransmission(const DriveSubject& subject, const PreparedLog& log, const std::vector<Block>& training,
                     const std::vector<Block>& heldout, const LogDiagnosisOptions& options, LogDiagnosis& result) {
  Diagnosis& d = result.diagnosis;
  const DriveEffect& effect = drive_effects::find("transmission-compliance");
  if (subject.base.kind != DriveKind::kFriction || !isWanted(options, effect.name)) return;
  for (DriveFitResult* fit : {&result.baseline, &result.extended}) {
    fit->extensions.insert(fit->extensions.end(), subject.of_angles.begin(), subject.of_angles.end());
  }
  const auto cannot = [&](const std::string& why) { d.not_testable.push_back({std::string(effect.name), why}); };
  if (!subject.of_angles.empty()) return cannot("the model already contains it");
  for (const Channel channel : effect.needs) {
    if (!log.data.has(channel)) return cannot(fmt::format("needs {}", toString(channel)));
  }
  if (log.data.rows.top_load == 0.0) return cannot("needs a load that changes");

  const PreparedLog angles = prepareTransmissionData(log);
  const LogSearch search(drive_equations::transmission, angles.data, training, options);
  const double range = angles.data.rows.effort.maxCoeff() - angles.data.rows.effort.minCoeff();
  if (std::sqrt(search.fit({}, nullptr).mse) < kDerived * range) return cannot("needs two measured angles");
  const Selection selection = selectCauses(search, {}, {{&effect, {}, {}}}, {}, options, {});
  Fitted before = selection.baseline, after = selection.chosen;
  const DriveFitResult rigid = describe(search, angles, before), elastic = describe(search, angles, after);
  const double samples = static_cast<double>(d.samples) / correlationTime(residualOf(after), log.data.rows.session);
  for (const Detectable& least : detectable(search, selection.last, options.least_gain, samples))
    d.detectable.push_back(least);
  for (HypothesisRecord record : selection.records) d.hypotheses.push_back(std::move(record));
  for (Cause& cause : causesOf(search, selection, heldout, rigid, elastic, 0, options.seed)) {
    const std::string found = fmt::format(
        "{}; the joint's angle follows from the motor's with {:.1f} % less squared "
        "error on data never used",
        cause.effect, 100.0 * cause.gain_heldout.value);
    if (d.verdict == DiagnosisVerdict::kNothingFound) {
      d.verdict = DiagnosisVerdict::kCauseFound;
      d.sentence = "Cause found: " + found + ".";
    } else {
      d.sentence += " And " + found + ".";
    }
    d.causes.push_back(std::move(cause));
  }
  d.extensions.insert(d.extensions.end(), elastic.extensions.begin(), elastic.extensions.end());
  result.extended.extensions.insert(result.extended.extensions.end(), elastic.extensions.begin(),
                                    elastic.extensions.end());
}

}  // namespace simgap
