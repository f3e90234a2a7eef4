// A spring between two points: it pulls when longer and pushes when shorter than at rest.
#include "simgap/model/arm/tendon_kind.h"

namespace simgap::tendon_kinds::spring {
namespace {

constexpr TendonParameter kParameters[] = {{"rest_length", "m", "rest_length_m", kAnyNumber},
                                           {"stiffness", "N_m", "stiffness_N_m", kPositive},
                                           {"damping", "Ns_m", "damping_Ns_m", kNonNegative}};

TendonPull pull(const TendonParameters& p, double length, double) {
  const double x = length - p[0];
  return {0.5 * p[1] * x * x, p[1] * x, p[1], {-p[1], x}};
}

double force(const TendonParameters& p, double length, double rate, double) {
  return p[1] * (length - p[0]) + p[2] * rate;
}

}  // namespace

extern const TendonKind entry;
const TendonKind entry{.name = "spring",
                       .what = "a spring that pulls when longer and pushes when shorter than at rest",
                       .equation = "F = stiffness (L - rest_length) + damping dL/dt",
                       .parameters = kParameters,
                       .pull = pull,
                       .force = force};

}  // namespace simgap::tendon_kinds::spring
