#include "simgap/diagnose/diagnosis.h"

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

}  // namespace simgap
