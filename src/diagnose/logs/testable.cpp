#include "testable.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr double kNoisyLoad = 0.01;  ///< of its variance: a copy gains by as much

/// Whether one of the bench's constants that are fitted multiplies nearly that channel.
bool isFitted(const Eigen::ArrayXd& channel, const ActuatorData& data) {
  constexpr double kAlike = 0.9;  // correlation: each may be smoothed in its own way
  for (Eigen::Index k = 0; k < data.rig.cols(); ++k) {
    const Eigen::ArrayXd column = data.rig.col(k);
    if (std::abs(correlation(spanOf(channel), spanOf(column))) > kAlike) return true;
  }
  return false;
}

/// Why an effect cannot be tested on this log; empty when it can.
std::string missingFor(const ActuatorEffect& effect, const ActuatorBase& base, const ActuatorData& data,
                       const std::vector<const ActuatorEffect*>& own) {
  if (std::ranges::find(own, effect.name, &ActuatorEffect::name) != own.end()) return "the model already contains it";
  if (base.law != nullptr) {
    const bool in_law = effect.contained_in != nullptr && effect.contained_in(*base.law);
    if (in_law || (effect.is_offset && data.offset)) {
      return fmt::format("part of the law {}, or without meaning in it", base.law->name);
    }
    if (effect.needs_stribeck && !base.law->hasStribeck()) return "needs a law with a Stribeck term";
  }
  if (effect.multiple_of != nullptr && isFitted(data.rows.*effect.multiple_of, data)) {
    return "a constant of the bench that is fitted says the same";
  }
  if (data.load_noise > kNoisyLoad && (effect.of_angle || effect.multiple_of != nullptr)) {
    return "the load is so noisy that a quieter copy of it would pass for this";
  }
  for (const OptionalChannel channel : effect.needs) {
    if (!data.rows.has(channel)) return fmt::format("needs {}", toString(channel));
  }
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
      for (const ActuatorEffect* form : effect->other_forms) list.push_back({form, {}, {}});
    } else {
      diagnosis.not_testable.push_back({std::string(effect->name), reason});
    }
  }
  return list;
}

}  // namespace simgap
