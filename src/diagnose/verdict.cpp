#include "verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace simgap {
namespace {

bool hasGroup(const std::vector<Cause>& causes) {
  return std::ranges::any_of(causes, [](const Cause& cause) { return !cause.ambiguous_with.empty(); });
}

}  // namespace

bool isLost(const std::vector<std::string>& ambiguous_with) { return ambiguous_with.size() + 1 > kLargestGroup; }

DiagnosisVerdict verdictOf(const std::vector<Cause>& causes, bool structure) {
  if (std::ranges::any_of(causes, isLost, &Cause::ambiguous_with)) return DiagnosisVerdict::kUnexplained;
  if (causes.empty()) return structure ? DiagnosisVerdict::kUnexplained : DiagnosisVerdict::kNothingFound;
  return hasGroup(causes) ? DiagnosisVerdict::kAmbiguous : DiagnosisVerdict::kCauseFound;
}

const DataFault* openFault(const std::vector<DataFault>& faults) {
  const auto open = std::ranges::find(faults, false, &DataFault::corrected);
  return open == faults.end() ? nullptr : &*open;
}

void endWith(const DataFault& fault, Diagnosis& diagnosis) {
  diagnosis.verdict = DiagnosisVerdict::kDataFault;
  diagnosis.sentence = "Data fault: " + fault.sentence + ".";
  diagnosis.baseline = diagnosis.extended = {std::nan(""), std::nan("")};
  diagnosis.noise_floor = diagnosis.explained_percent = diagnosis.explainable_percent = std::nan("");
}

std::string nameOf(const Cause& cause) {
  return cause.target.empty() ? cause.effect : cause.effect + " of " + cause.target;
}

std::string namesOf(const std::vector<Cause>& causes) {
  std::vector<std::string> names;
  for (const Cause& cause : causes) {
    std::string& name = names.emplace_back(nameOf(cause));
    for (const std::string& other : cause.ambiguous_with) name += " or " + other;
  }
  return fmt::format("{}", fmt::join(names, hasGroup(causes) ? "; and " : ", "));
}

double detectionFactor(double least_gain, double effective_samples) {
  return std::max(4.6, std::sqrt(least_gain * effective_samples));
}

std::vector<Absorption> absorbed(std::vector<Absorption> shifts) {
  constexpr double kSmallest = 2.0;  // [sd]: what chance alone does in one parameter of twenty
  constexpr std::size_t kMost = 5;
  std::erase_if(shifts, [](const Absorption& a) { return !(std::abs(a.shift_sd) >= kSmallest); });
  std::ranges::stable_sort(shifts, std::greater<>(), [](const Absorption& a) { return std::abs(a.shift_sd); });
  if (shifts.size() > kMost) shifts.resize(kMost);
  return shifts;
}

}  // namespace simgap
