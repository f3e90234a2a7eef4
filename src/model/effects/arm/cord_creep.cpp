/// Cords and lines lengthen under load for as long as they are used, fast at first: v T log(1 + t / T) after t, which
/// is v t while t is short and slows down beyond T (logarithmic creep of polymers).
#include <algorithm>
#include <cmath>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::cord_creep {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"rate", "m_s", {-1e-3, 1e-3, false, "a number in [-1e-3, 1e-3]"}, 0.0, 5e-6, true, ArmSize::kLength},
    {"time_constant", "s", {1.0, 1e7, false, "a number in [1, 1e7]"}, 1800.0, 1800.0}};
constexpr EffectParameters kStarts[] = {{1e-6, 400.0}, {1e-6, 8000.0}, {1e-5, 2000.0}};
constexpr std::string_view kLookAlikes[] = {"potentiometer-slip"};

Lengthening line(const EffectParameters& p, const LineState& s) {
  const double t = std::max(0.0, s.time);
  const double grown = std::log1p(t / p[1]);
  return {p[0] * p[1] * grown, 0.0, 0.0, {p[1] * grown, p[0] * (grown - t / (p[1] + t))}};
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "cord-creep",
                      .cause = "the shock cord or the kite line lengthens in the course of the session",
                      .equation = "L_K = L_K0 - r phi + rate T log(1 + t / T)",
                      .signature = "a drift in the order of recording",
                      .remarks = "T is `time_constant`: linear at first, slowing down beyond T",
                      .target = ArmEffect::Target::kMuscleOrAll,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "repeat one early pose every ten minutes: creep drifts on, a slip is one step",
                      .needs_time = true,
                      .line = line};

}  // namespace simgap::arm_effects::cord_creep
