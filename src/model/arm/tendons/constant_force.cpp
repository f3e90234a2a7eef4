// A line under a force that does not change: a weight over a pulley, a constant-force spring.
#include "simgap/model/arm/tendon_kind.h"

namespace simgap::tendon_kinds::constant_force {
namespace {

constexpr TendonParameter kParameters[] = {{"force", "N", "force_N", kNonNegative}};

TendonPull pull(const TendonParameters& p, double length, double) { return {p[0] * length, p[0], 0.0, {1.0}}; }

double force(const TendonParameters& p, double, double, double) { return p[0]; }

}  // namespace

extern const TendonKind entry;
const TendonKind entry{.name = "constant-force",
                       .what = "a line under a force that does not change: a weight, a constant-force spring",
                       .equation = "F = force",
                       .parameters = kParameters,
                       .pull = pull,
                       .force = force};

}  // namespace simgap::tendon_kinds::constant_force
