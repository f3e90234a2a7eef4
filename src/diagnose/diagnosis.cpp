#include "simgap/diagnose/diagnosis.h"

#include <fmt/format.h>

namespace simgap {

std::string_view toString(DiagnosisVerdict verdict) {
  switch (verdict) {
    case DiagnosisVerdict::kCauseFound:
      return "cause-found";
    case DiagnosisVerdict::kAmbiguous:
      return "ambiguous";
    case DiagnosisVerdict::kUnexplained:
      return "unexplained";
    case DiagnosisVerdict::kNothingFound:
      return "nothing-found";
    case DiagnosisVerdict::kDataFault:
      return "data-fault";
  }
  return "";
}

void warnOfHarm(Diagnosis& diagnosis) {
  for (const Cause& cause : diagnosis.causes) {
    if (cause.gain_heldout.value >= 0.0) continue;
    diagnosis.warnings.push_back(
        fmt::format("{} makes the data it was not chosen on worse, by {:.0f} %: doubt it until more is recorded",
                    cause.effect, -100.0 * cause.gain_heldout.value));
  }
}

}  // namespace simgap
