/// \file
/// An offset of the pressure sensor: f = (p - p0) g(e).
#include "simgap/model/drive_effect.h"

namespace simgap::drive_effects {
namespace {

constexpr EffectParameter kParameters[] = {{"p0", "Pa", -5e5, 5e5, 0.0, 0.0}};

void apply(std::span<const double> p, const DriveRows& /*rows*/, DriveTerms& terms) { terms.pressure -= p[0]; }

}  // namespace

extern const DriveEffect pressure_bias;
const DriveEffect pressure_bias = {
    .name = "pressure-bias",
    .kind = DriveKind::kMuscle,
    .cause = "the pressure sensor has an offset",
    .equation = "f = (p - p0) g(e)",
    .source = "catalogue of causes",
    .look_alikes = "pressure-threshold: the same equation while it lowers the pressure",
    .separates = "the pressure sensor's reading with the muscle vented",
    .parameters = kParameters,
    .apply = apply,
};

}  // namespace simgap::drive_effects
