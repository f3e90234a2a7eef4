// A ligament: a line of a joint's capsule or a rope, elastic once it is taut (000 section IV).
#include <algorithm>

#include "simgap/model/arm/tendon_kind.h"

namespace simgap::tendon_kinds::ligament {
namespace {

constexpr TendonParameter kParameters[] = {{"rest_length", "m", "rest_length_m", kPositive},
                                           {"stiffness", "N_m", "stiffness_N_m", kPositive},
                                           {"damping", "Ns_m", "damping_Ns_m", kNonNegative}};

TendonPull pull(const TendonParameters& p, double length, double) {
  const double x = length - p[0];
  if (x <= 0.0) return {};
  return {0.5 * p[1] * x * x, p[1] * x, p[1], {-p[1], x}};
}

double force(const TendonParameters& p, double length, double rate, double) {
  const double x = length - p[0];
  return x > 0.0 ? std::max(0.0, p[1] * x + p[2] * rate) : 0.0;
}

}  // namespace

extern const TendonKind entry;
const TendonKind entry{.name = "ligament",
                       .what = "an elastic line that only pulls: slack below its rest length",
                       .equation = "F = max(0, stiffness (L - rest_length) + damping dL/dt) while L > rest_length",
                       .parameters = kParameters,
                       .pull = pull,
                       .force = force};

}  // namespace simgap::tendon_kinds::ligament
