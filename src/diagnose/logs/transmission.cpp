#include "transmission.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "free_shape.h"
#include "log_causes.h"
#include "log_conclusion.h"
#include "simgap/measure/logs/log_kind.h"
#include "simgap/optimize/uncertainty.h"
#include "testable.h"

namespace simgap {
namespace {

constexpr double kDerived = 1e-9;  // of the joint's range: one angle was worked out from the other

/// Why what seems to stretch may be an error of an encoder, which goes with the angle as many loads do: empty where
/// the cause explains something beside any error over the angle.
std::string doubtOfStretch(const LogSearch& search, const Selection& selection, const std::vector<Block>& heldout,
                           const std::vector<int>& session, std::uint64_t seed) {
  const auto beside = [&](const Fitted& fitted) { return besideShapeOver(search, fitted, ShapeOver::kMotorAngle); };
  const std::vector<Eigen::VectorXd> unseen =
      heldOutResiduals(search, {beside(selection.baseline), beside(selection.chosen)}, heldout, session);
  const auto sumOf = [&](const Eigen::VectorXd& errors) { return heldOutErrors(search, errors, heldout, session).sum; };
  const Interval gain = predictedGain(sumOf(unseen[0]), sumOf(unseen[1]), seed);
  if (gain.lower95 > 0.0 && nestedP(search.added(unseen[0], unseen[1], heldout)) < 0.01) return {};
  return fmt::format(
      "beside an error of the encoders over the angle it may explain nothing ({:.1f} %, {:.1f} to {:.0f})",
      100.0 * gain.value, 100.0 * gain.lower95, 100.0 * gain.upper95);
}

}  // namespace

void addTransmission(const ActuatorModel& subject, const PreparedLog& log, const LogSplit& split,
                     const LogDiagnosisOptions& options, LogDiagnosis& result) {
  Diagnosis& d = result.diagnosis;
  if (!kindOf(subject.base.kind).at_joint) return;
  ActuatorModel transmission{*actuator_equations::find(ActuatorKind::kTransmission), {}, {}};
  for (const Extension& own : subject.of_angles) {
    transmission.effects.push_back(&actuator_effects::find(own.effect, own.form));
    for (LogFit* fit : {&result.baseline, &result.extended}) fit->extensions.push_back(own);
  }
  // One cause: what is left beside a cable that stretches is the shape of its law, and a step would pass for play.
  if (!transmission.effects.empty()) return;
  const std::vector<Hypothesis> hypotheses = namedHypotheses(transmission, log.data, options, d);
  if (hypotheses.empty()) return;
  LogDiagnosisOptions of_one = options;
  of_one.max_causes = 1;
  const PreparedLog angles = prepareTransmissionData(log);
  const LogSearch search(transmission.base, angles.data, split.training, options);
  const double range = angles.data.rows.effort.maxCoeff() - angles.data.rows.effort.minCoeff();
  if (std::sqrt(search.fit({}, nullptr).mse) < kDerived * range) {
    d.not_testable.push_back({std::string(hypotheses[0].effect->name), "needs two measured angles"});
    return;
  }
  const Selection selection = selectCauses(search, {}, hypotheses, {}, of_one, {});
  Fitted before = selection.baseline, after = selection.chosen;
  const LogFit rigid = describe(search, angles, before), elastic = describe(search, angles, after);
  const double samples = static_cast<double>(d.samples) / correlationTime(residualOf(after), log.data.rows.session);
  addDetectable(search, selection.last, options.least_gain, samples, d);
  for (HypothesisRecord record : selection.records) d.hypotheses.push_back(std::move(record));
  std::vector<GroupErrors> heldout;
  for (const Eigen::VectorXd& unseen :
       heldOutResiduals(search, selection.steps, split.heldout, log.data.rows.session)) {
    heldout.push_back(heldOutErrors(search, unseen, split.heldout, log.data.rows.session));
  }
  for (Cause& cause : causesOf(selection, heldout, rigid, elastic, 0, options.seed)) {
    std::string doubt = doubtOfStretch(search, selection, split.heldout, log.data.rows.session, options.seed);
    if (doubt.empty() && cause.gain_heldout.lower95 < options.least_gain)
      doubt = "its gain on held-out data may be nothing";
    if (!doubt.empty()) {
      d.candidates.push_back({cause.effect, {}, doubt, cause.gain_heldout});
      return;
    }
    const std::string found = fmt::format(
        "{}; the joint's angle follows from the motor's with {:.1f} % less squared "
        "error on data never used",
        cause.effect, 100.0 * cause.gain_heldout.value);
    if (d.verdict == DiagnosisVerdict::kNothingFound) {
      d.verdict = DiagnosisVerdict::kCauseFound;
      d.sentence = "Cause found: " + found + ". Of the effort no cause was found.";
    } else if (d.causes.empty()) {
      d.verdict = DiagnosisVerdict::kCauseFound;
      d.sentence = fmt::format("Found: {}. Of the effort no cause was found. Left: {}.", found, leftText(d));
    } else {
      d.sentence += " And " + found + ".";
    }
    d.causes.push_back(std::move(cause));
  }
  result.extended.extensions.insert(result.extended.extensions.end(), elastic.extensions.begin(),
                                    elastic.extensions.end());
}

}  // namespace simgap
