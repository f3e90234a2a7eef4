#include "testable.h"

#include <fmt/format.h>

#include <algorithm>

namespace simgap {
namespace {

constexpr const char* kNoLoad = "needs a load that changes";

/// Why an effect cannot be tested on this log; empty when it can.
std::string missingFor(const ActuatorEffect& effect, const ActuatorBase& base, const ActuatorData& data,
                       const std::vector<const ActuatorEffect*>& own) {
  for (const OptionalChannel channel : effect.needs) {
    if (!data.rows.has(channel)) return fmt::format("needs {}", toString(channel));
  }
  if (std::ranges::find(own, &effect) != own.end()) return "the model already contains it";
  if (effect.kind == ActuatorKind::kTransmission && data.rows.top_load == 0.0) return kNoLoad;
  if (base.law == nullptr) return {};
  const FrictionLaw& law = *base.law;
  const auto hasTerm = [&](FrictionBasis basis, FrictionShape shape) {
    return std::ranges::any_of(law.terms, [&](const FrictionTerm& t) { return t.basis == basis && t.shape == shape; });
  };
  const bool offset = hasTerm(FrictionBasis::kDirection, FrictionShape::kSliding) ||
                      hasTerm(FrictionBasis::kDirection, FrictionShape::kAlways);
  const bool in_law = (effect.name == "coulomb-offset" && offset) ||
                      (effect.name == "static-offset" &&
                       (hasTerm(FrictionBasis::kDirection, FrictionShape::kStatic) || !law.hasStribeck())) ||
                      (effect.name == "stribeck" && law.hasStribeck()) ||
                      (effect.name == "load-dependence" && law.needsLoad()) ||
                      (effect.name == "current-bias" && data.offset);
  if (in_law) return fmt::format("part of the law {}, or without meaning in it", law.name);
  if (effect.name == "stiction-ageing" && !law.hasStribeck()) return "needs a law with a Stribeck term";
  if (effect.name == "stiction-ageing" && !(data.rows.rest > 0.5).any()) return "needs rests of 1 s and longer";
  const bool needs_load = effect.name == "load-dependence" || effect.name == "load-nonlinearity" ||
                          effect.name == "backdrive-asymmetry" || effect.name == "torque-constant-heating";
  if (needs_load && data.rows.top_load == 0.0) return kNoLoad;
  return {};
}

}  // namespace

std::vector<Hypothesis> namedHypotheses(const ActuatorModel& subject, const ActuatorData& data,
                                        const LogDiagnosisOptions& options, Diagnosis& diagnosis) {
  std::vector<Hypothesis> list;
  for (const ActuatorEffect* effect : actuator_effects::all()) {
    if (!appliesTo(*effect, subject.base.kind)) continue;
    if (!options.wants(effect->name)) continue;
    const std::string reason = missingFor(*effect, subject.base, data, subject.effects);
    if (reason.empty()) {
      list.push_back({effect, {}, {}});
    } else {
      diagnosis.not_testable.push_back({std::string(effect->name), reason});
    }
  }
  return list;
}

}  // namespace simgap
