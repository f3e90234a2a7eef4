#include "simgap/core/json_numbers.h"

#include <fmt/format.h>

#include <cmath>

namespace simgap {

long wholeNumber(const Json& json) {
  constexpr double kExact = 9007199254740992.0;  // 2^53
  const double number = json.is_number() ? json.get<double>() : std::nan("");
  if (std::abs(number) <= kExact && number == std::floor(number)) return static_cast<long>(number);
  throw Json::type_error::create(302, fmt::format("found {}, expected a whole number", json.dump().substr(0, 40)),
                                 &json);
}

}  // namespace simgap
