/// Where a line is redirected, over an eyelet or a pulley, friction takes a share of its tension, against the way it
/// last moved (Euler-Eytelwein, T_out = T_in exp(-mu theta) for a bend by theta; loss = 1 - exp(-mu theta)): after
/// winding the arm gets less than the cord at the motor pulls with, after unwinding more.
#include <cmath>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::pulley_friction {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"loss", "1", {-0.2, 0.9, false, "a number in [-0.2, 0.9]"}, 0.0, 0.1, true, ArmSize::kNone, true},
    {"from_previous", "1", {0.0, 1.0, false, "0 or 1"}, 0.0, 1.0, false}};
constexpr EffectParameters kStarts[] = {{0.05, 0.0}, {0.05, 1.0}};
constexpr std::string_view kLookAlikes[] = {"joint-stiction", "cord-hardening"};
constexpr double kStill = 0.01;  // [rad]: a shaft that has hardly moved has no direction

/// 1 after winding, -1 after unwinding.
double direction(const EffectParameters& p, const LineState& state) {
  const double wound = state.shaft - (p[1] != 0.0 ? state.before : 0.0);
  return std::abs(wound) < kStill ? 0.0 : std::copysign(1.0, wound);
}

CordTerm cord(const EffectParameters& p, double x, const ShockCord& cord, const LineState& state) {
  const double lost = -p[0] * direction(p, state);
  return {.energy = 0.5 * lost * cord.stiffness * x * x,
          .force = lost * cord.stiffness * x,
          .stiffness = lost * cord.stiffness,
          .by_stiffness = lost * x,
          .by_rest_length = 0.0,
          .by_parameter = {-direction(p, state) * cord.stiffness * x}};
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "pulley-friction",
    .cause = "friction where the line is redirected takes a share of its tension, by the direction of winding",
    .equation = "F = k x (1 - loss s), s = 1 after winding, -1 after unwinding",
    .signature = "a tension error in proportion to the tension, whose sign changes with the direction of winding",
    .remarks =
        "the direction is that from rest, or from the pose before (`from_previous` 1); a shaft that has moved by less "
        "than 0.01 rad has none",
    .target = ArmEffect::Target::kMuscleOrAll,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "approach the same command once by winding this muscle and once by unwinding it: the tension differs by twice "
        "the loss, while friction of a joint does not ask which muscle moved",
    .from_previous = 1,
    .cord = cord};

}  // namespace simgap::arm_effects::pulley_friction
