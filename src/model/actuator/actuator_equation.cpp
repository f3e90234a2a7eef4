#include "simgap/model/actuator/actuator_equation.h"

#include <algorithm>

namespace simgap::actuator_equations {

const ActuatorEquation* find(ActuatorKind kind) {
  const auto found = std::ranges::find(all(), kind, &ActuatorEquation::kind);
  return found == all().end() ? nullptr : *found;
}

}  // namespace simgap::actuator_equations
