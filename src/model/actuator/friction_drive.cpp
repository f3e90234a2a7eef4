#include "simgap/model/actuator/friction_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "simgap/core/error.h"

namespace simgap {

DriveFeedForward feedForward(const FrictionLaw& law, std::span<const Estimate> estimates) {
  const auto value = [&](std::string_view name, double otherwise) {
    const auto found = std::ranges::find(estimates, name, &Estimate::name);
    return found == estimates.end() ? otherwise : found->value;
  };
  std::vector<double> theta;
  for (const FrictionTerm& term : law.terms) theta.push_back(value(term.name, 0.0));
  DriveFeedForward drive{law.closed_form(theta), value("k_a", 1.0), value("offset", 0.0)};
  drive.friction.v_s = value("v_s", 1.0);
  drive.friction.delta = value("delta", 1.0);
  return drive;
}

DriveFeedForward feedForward(const FittedModel& model) {
  const auto require = [&](const char* key, const char* expected) {
    if (const std::string found = model.setting(key, expected); found != expected) {
      throw ConfigError(fmt::format("found a model with {}: {}, expected {}", key, found, expected));
    }
  };
  require("effort_unit", "A");
  require("load_unit", "Nm");
  require("predicts", "effort");
  if (!model.extensions.empty()) {
    throw ConfigError("found causes that were added to the friction law, expected what fit-friction leaves");
  }
  const DriveFeedForward drive = feedForward(friction::find(model.law), model.parameters);
  const StribeckFriction& f = drive.friction;
  if (!(drive.k_a > 0.0 && f.v_s > 0.0 && f.delta > 0.0 && std::min({f.n_c1, f.n_c2, f.n_s1, f.n_s2, f.k_v}) >= 0.0)) {
    throw ConfigError("found a friction law with values below 0, expected k_a, v_s and delta > 0, the others >= 0");
  }
  return drive;
}

}  // namespace simgap
