#include "simgap/model/friction/friction_law.h"

#include <fmt/format.h>

#include <string>

#include "simgap/core/error.h"

namespace simgap::friction {

const FrictionLaw& find(std::string_view name) {
  std::string names;
  for (const FrictionLaw* law : all()) {
    if (law->name == name) return *law;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", law->name);
  }
  throw ConfigError(fmt::format("found the friction law '{}', expected one of {}", name, names));
}

}  // namespace simgap::friction
