/// \file
/// Which causes the candidates of an arm's diagnosis hold.
#pragma once

#include "diagnose/arm_cause.h"
#include "simgap/intervene/intervention.h"

namespace simgap {

/// \tparam Evidence  with the given model and candidates with theirs
template <class Evidence>
HeldCauses heldBy(const Evidence& evidence) {
  HeldCauses held;
  for (const auto& candidate : evidence.candidates) {
    std::set<std::string>& causes = held.emplace_back();
    for (const ArmCause& cause : causesBeyond(evidence.given, candidate.model)) causes.insert(cause.label());
  }
  return held;
}

}  // namespace simgap
