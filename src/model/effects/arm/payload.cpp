/// A body carries a mass that the model does not have, at a distance from its joint on the line through its centre of
/// mass.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::payload {
namespace {

// Of no size of the arm: often only mass x distance is known, and wider priors leave both without meaning.
constexpr ArmEffectParameter kParameters[] = {{"mass", "kg", {-2.0, 20.0, false, "a number in [-2, 20]"}, 0.0, 1.0},
                                              {"distance", "m", {0.0, 2.0, false, "a number in [0, 2]"}, 0.15, 0.1}};
constexpr EffectParameters kStarts[] = {{0.05, 0.15}};
constexpr std::string_view kLookAlikes[] = {"gravity-tilt", "passive-joint-torque"};

PointMass mass(const EffectParameters& p) { return {p[0], p[1], {1.0, 0.0}, {0.0, 1.0}}; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "payload",
                      .cause = "the body carries a mass that the model does not have",
                      .equation = "E = ... - mass g.x at the distance from the joint",
                      .remarks =
                          "the mass lies on the way from the joint through the body's centre of mass. For a body "
                          "next to the torso only mass x distance acts",
                      .target = ArmEffect::Target::kMovingBody,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "weigh the body, or hang a known mass on it and record the same poses again",
                      .law_sd = 0.1,  // held beside the bone, and no point
                      .mass = mass};

}  // namespace simgap::arm_effects::payload
