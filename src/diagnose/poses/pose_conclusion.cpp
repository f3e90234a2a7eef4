#include "pose_conclusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnose/verdict.h"
#include "impossible_sizes.h"
#include "simgap/model/arm/arm_effect.h"

namespace simgap {
namespace {

constexpr double kLargeExcess = 0.5;   // of the cross-validated error over what the model itself expects
constexpr double kClearExcess = 4.0;   // standard deviations
constexpr double kFaintExcess = 2.0;   // standard deviations, from which it is said
constexpr double kFarFromNoise = 2.0;  // RMS, in noise floors
constexpr double kSmallRest = 0.05;    // of the error without causes: what the law of a named cause may leave
constexpr double kHardly = 0.05;       // of the error beyond noise: what causes that are none may take away
constexpr double kNearNoise = 1.25;    // RMS, in noise floors: what poses not fitted to may have

/// Structure on poses not fitted to. \param excess  with or without the causes
bool isStructure(double excess, double sd) { return excess > kLargeExcess && excess > kClearExcess * sd; }

std::string foundText(const PoseSelection& selection, std::size_t heldout, const Diagnosis& d) {
  const double left = d.extended.mse_heldout / d.baseline.mse_heldout;
  const bool one = d.causes.size() == 1;
  const std::string names = labelOf(selection.allCauses());
  if (!(left < 1.0)) {
    return fmt::format("{} {} the poses more probable, but {} poses that were held out do not show it", names,
                       one ? "makes" : "make", heldout);
  }
  const double times = leftInNoise(d, d.noise_floor);
  const std::string rest = times > kNearNoise ? fmt::format("{:.1f} times the noise", times) : "about the noise";
  return fmt::format("{} {} {:.0f} % of the squared error on {} poses that were held out. Left: {:.0f} %, {}", names,
                     one ? "takes away" : "take away", 100.0 * (1.0 - left), heldout, 100.0 * left, rest);
}

std::string unexplainedText(const PoseSelection& selection, const Diagnosis& d) {
  for (const Cause& cause : d.causes) {
    if (!isLost(cause.ambiguous_with)) continue;
    return fmt::format("something like {} is there, but these poses do not tell it from {} other causes",
                       effectLabel(cause.effect, cause.target), cause.ambiguous_with.size());
  }
  if (selection.tethered) {
    return "something pulls on the arm as a base would that is too far off level not to be seen: a tether, a hose?";
  }
  return fmt::format(
      "the squared error on unseen poses is {:.0f} % above what noise and parameters explain, and no cause of the "
      "catalogue "
      "takes it away",
      100.0 * selection.excess);
}

/// What poses not fitted to show beyond noise where that is no structure: mostly what is not known of the parameters.
std::string beyondNoise(const PoseSelection& selection, const Diagnosis& d) {
  const double times = leftInNoise(d, d.noise_floor);
  if (times <= kNearNoise) return {};
  if (selection.excess > kFaintExcess * selection.excess_sd) {
    return fmt::format("; their squared error is {:.0f} % above what noise and parameters explain",
                       100.0 * selection.excess);
  }
  return fmt::format("; left is {:.1f} times the noise, no more than unsure parameters explain", times);
}

/// A tilt that nobody would miss is more likely something else that pulls.
void warnOfTilt(Diagnosis& d) {
  constexpr double kNoticed = 0.15;  // [rad]
  for (const Cause& cause : d.causes) {
    const ArmEffect* effect = findArmEffect(cause.effect);
    if (effect == nullptr || effect->gravity == nullptr) continue;
    const double tilt = tiltOf(cause.parameters);
    if (tilt <= kNoticed) continue;
    d.warnings.push_back(
        fmt::format("{}: look whether the base is {:.0f} deg off level; if it is not, something else pulls in one "
                    "direction, such as a tether or a hose",
                    cause.effect, toDegrees(tilt)));
  }
}

}  // namespace

double leftInNoise(const Diagnosis& d, double noise) {
  return noise > 0.0 ? std::sqrt(d.extended.mse_heldout / noise) : 0.0;
}

bool leavesTooMuch(const PoseSelection& selection, const Diagnosis& d, double noise) {
  const double times = leftInNoise(d, noise), taken = d.baseline.mse_heldout - d.extended.mse_heldout;
  const bool partial = isStructure(selection.excess, selection.excess_sd) && times > kFarFromNoise &&
                       d.extended.mse_heldout > kSmallRest * d.baseline.mse_heldout;
  // Of what the model without causes leaves: causes that were taken back since had lowered the excess.
  const bool hardly = isStructure(selection.excess_plain, selection.excess_sd) && times > kNearNoise &&
                      taken < kHardly * (d.baseline.mse_heldout - noise);
  return partial || hardly;
}

void concludePoses(const PoseSelection& selection, std::size_t heldout, bool partial, Diagnosis& d) {
  const bool structure = isStructure(selection.excess, selection.excess_sd);
  const DataFault* fault = openFault(d.faults);
  d.verdict =
      fault != nullptr ? DiagnosisVerdict::kDataFault : verdictOf(d.causes, structure || partial || selection.tethered);
  switch (d.verdict) {
    case DiagnosisVerdict::kDataFault:
      d.sentence = fault->sentence;
      break;
    case DiagnosisVerdict::kCauseFound:
    case DiagnosisVerdict::kAmbiguous:
      d.sentence = foundText(selection, heldout, d);
      break;
    case DiagnosisVerdict::kUnexplained:
      d.sentence = unexplainedText(selection, d);
      break;
    case DiagnosisVerdict::kNothingFound:
      d.sentence = "no cause of the catalogue improves the model on poses it has not seen";
      d.sentence += beyondNoise(selection, d);
  }
  warnOfTilt(d);
  if (structure && d.verdict == DiagnosisVerdict::kCauseFound) {
    d.warnings.push_back(
        fmt::format("the squared error on unseen poses is still {:.0f} % above what noise and parameters explain",
                    100.0 * selection.excess));
  }
}

}  // namespace simgap
