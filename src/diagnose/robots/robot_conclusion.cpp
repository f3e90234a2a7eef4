#include "robot_conclusion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "diagnose/verdict.h"
#include "robot_findings.h"
#include "simgap/fit/dynamics/dynamics_fit.h"
#include "simgap/fit/dynamics/pseudo_inertia.h"
#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const RobotHypothesis* findLabel(const RobotSearch& search, const std::string& label) {
  for (std::size_t h = 0; h < search.size(); ++h) {
    if (search.hypothesis(h).label() == label) return &search.hypothesis(h);
  }
  return nullptr;
}

/// Joints whose error is beyond what it was when their numbers were found: "j2 (3.1 times), j3 (2.2 times)".
std::string beyondKnown(const std::vector<JointVerdict>& joints) {
  std::vector<std::string> names;
  for (const JointVerdict& joint : joints) {
    if (joint.times_known > kBeyondKnown)
      names.push_back(fmt::format("{} ({:.1f} times)", joint.joint, joint.times_known));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string elsewhereText(const std::vector<LeftAtJoint>& joints) {
  std::string text;
  for (const LeftAtJoint& joint : joints) {
    text += fmt::format("; {:.0f} % of the squared error of {}, on which no named cause acts, by {}",
                        100.0 * joint.share, joint.joint, joint.channels.front().channel);
  }
  return text;
}

/// The simplest law of friction that holds what several joints show; empty: none.
std::string lawOfMostJoints(const std::vector<Cause>& causes) {
  for (const ActuatorEffect* effect : actuator_effects::all()) {
    const auto shown = std::ranges::count(causes, std::string(effect->name), &Cause::effect);
    if (!effect->on_robot || effect->contained_in == nullptr || shown < 2) continue;
    std::vector<const FrictionLaw*> laws(friction::all().begin(), friction::all().end());
    std::erase_if(laws, [&](const FrictionLaw* law) { return !effect->contained_in(*law); });
    if (laws.empty()) continue;
    const auto terms = [](const FrictionLaw* law) { return law->terms.size(); };
    return std::string((*std::ranges::min_element(laws, {}, terms))->name);
  }
  return {};
}

std::string nextStep(const RobotSearch& search, const RobotSelection& selection, const RobotDiagnosis& result) {
  const Diagnosis& d = result.diagnosis;
  for (std::size_t k = 0; k < d.causes.size(); ++k) {
    const Cause& cause = d.causes[k];
    if (cause.ambiguous_with.empty()) continue;
    std::string text =
        fmt::format("To tell {} from {}: record {}", nameOf(cause), fmt::join(cause.ambiguous_with, ", "),
                    search.hypothesis(selection.set[k]).separates);
    for (const std::string& other : cause.ambiguous_with) {
      const RobotHypothesis* rival = findLabel(search, other);
      if (rival != nullptr && rival->cause != cause.effect) text += "; and " + rival->separates;
    }
    return text + ".";
  }
  if (const std::string law = lawOfMostJoints(d.causes); !law.empty()) {
    return fmt::format("Several joints show what a law of friction has: find the robot with fit-dynamics --law {}.",
                       law);
  }
  if (!d.causes.empty()) {
    return fmt::format("To confirm {} independently: record {}.", nameOf(d.causes.front()),
                       search.hypothesis(selection.set.front()).separates);
  }
  if (d.verdict == DiagnosisVerdict::kUnexplained && !d.unexplained.empty()) {
    const std::string& channel = d.unexplained.front().channel;
    if (channel == "time") return "Repeat the first motion at the end: that tells a drift.";
    if (channel.starts_with(kAllNumbers)) {
      return "More than one number of its bodies or drives has changed, or the known ones are wrong: find the robot "
             "from this log, too (fit-dynamics), and compare the two base_parameters.csv.";
    }
    return fmt::format("Repeat one motion while {} goes slowly over its range and the rest is held.", channel);
  }
  if (d.verdict == DiagnosisVerdict::kUnexplained) {
    return "Record the motion of the log of the known robot again: an error that is as large there is a change of the "
           "robot or of its sensors; one that is not is something that motion never asked for.";
  }
  if (d.verdict != DiagnosisVerdict::kNothingFound) return {};
  return "Nothing is missing at this noise; a motion from `simgap design --excite` shows smaller effects than those "
         "under `detectable`.";
}

}  // namespace

void addUntestable(const RobotSearch& search, bool known, Diagnosis& d) {
  for (const RobotCause* cause : robot_causes::all()) {
    for (const std::string_view name : cause->names()) {
      bool any = false, open = false;
      for (std::size_t h = 0; h < search.size(); ++h) {
        if (search.hypothesis(h).cause != name) continue;
        any = true;
        open = open || search.testable(h);
      }
      if (!any || open) continue;
      d.not_testable.push_back(
          {std::string(name),
           known ? "what is known of the robot leaves it open"
                 : "the fit of bodies and drives to this log says the same: give the robot as fit-dynamics finds "
                   "it from a log without the cause"});
    }
  }
}

void addDetectable(const RobotSearch& search, const RobotSelection& selection, const RobotDiagnosisOptions& options,
                   Diagnosis& d) {
  const double factor = detectionFactor(options.least_gain, d.effective_samples);
  for (std::size_t h = 0; h < search.size(); ++h) {
    const RobotHypothesis& hypothesis = search.hypothesis(h);
    if (hypothesis.ordinary || !search.testable(h) || hypothesis.parameters.size() != 1 || !hypothesis.form.empty())
      continue;
    if (std::ranges::find(selection.set, h) != selection.set.end()) continue;
    RobotSearch::Set set = selection.set;
    set.push_back(h);
    const MatrixXd covariance = search.covariance(set, search.fit(set, kRobotFolds));
    const double sd = std::sqrt(std::max(0.0, covariance(covariance.rows() - 1, covariance.cols() - 1)));
    const RobotCauseParameter& parameter = hypothesis.parameters.front();
    d.detectable.push_back({hypothesis.cause, hypothesis.target, parameter.name, parameter.unit, factor * sd});
  }
}

void concludeRobot(const RobotSearch& search, const RobotSelection& selection, RobotDiagnosis& result) {
  Diagnosis& d = result.diagnosis;
  const std::string beyond = beyondKnown(result.joints);
  d.verdict = verdictOf(d.causes, d.left_over_percent >= 1.0 || !beyond.empty());
  const std::string shown_by_none = beyond.empty() ? "nothing that the logged channels show" : "what no channel shows";
  const std::string left = (d.unexplained.empty() ? shown_by_none
                                                  : fmt::format("{:.0f} % of the squared error, by {}",
                                                                d.left_over_percent, d.unexplained.front().channel)) +
                           elsewhereText(result.elsewhere);
  if (d.verdict == DiagnosisVerdict::kNothingFound) {
    d.sentence = "Nothing found: no cause improves the model of any joint on data it has not seen.";
  } else if (!d.causes.empty() && d.verdict == DiagnosisVerdict::kUnexplained) {
    d.sentence = fmt::format("Unexplained: these motions do not tell apart {}. Left: {}.", namesOf(d.causes), left);
  } else if (d.causes.empty()) {
    d.sentence = fmt::format("Unexplained: no cause of the catalogue was found. Left: {}.", left);
  } else {
    d.sentence = fmt::format("Found{}: {} ({:.0f} % of the squared error on data never used). Left: {}.",
                             d.verdict == DiagnosisVerdict::kAmbiguous ? ", but not alone" : "", namesOf(d.causes),
                             d.explained_percent, left);
  }
  if (!beyond.empty()) {
    d.sentence += fmt::format(" Beyond the squared error of the log in which the robot was found: {}.", beyond);
  }
  d.next_experiment = nextStep(search, selection, result);
}

bool holdCause(const RobotRegressor& regressor, const BaseParameters& base, const RobotHypothesis& hypothesis,
               const VectorXd& theta, const MatrixXd& covariance, RobotModel& robot) {
  if (hypothesis.hold) return hypothesis.hold(theta, robot);
  if (!hypothesis.change) return false;
  const VectorXd parameters = robot.parameters + hypothesis.change(theta);
  for (std::size_t b = 0; b < regressor.bodies(); ++b) {
    if (regressor.massless(b)) continue;
    if (!(smallestMoment(parameters.segment<kBodyParameters>(regressor.bodyColumn(b))) > 0.0)) return false;
  }
  MatrixXd slopes(base.combination.rows(), theta.size());
  for (Index k = 0; k < theta.size(); ++k) {
    const double step = hypothesis.parameters[k].step;
    VectorXd before = theta, after = theta;
    before[k] -= step;
    after[k] += step;
    slopes.col(k) = base.combination * (hypothesis.change(after) - hypothesis.change(before)) / (2.0 * step);
  }
  robot.base_covariance += slopes * covariance * slopes.transpose();
  robot.parameters = parameters;
  robot.arm = armWith(robot.arm, regressor, parameters);
  return true;
}

}  // namespace simgap
