/// A body resists turning more, or less, than its model: its mass lies farther out, at the same centre.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::inertia_error {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"factor", "1", {0.1, 20.0, false, "a number in [0.1, 20]"}, 1.0, 0.5}};
constexpr EffectParameters kStarts[] = {{1.5}, {3.0}, {0.6}};
constexpr std::string_view kLookAlikes[] = {"payload"};

/// Point masses on the three principal axes that add (factor - 1) I, and take their mass away at the centre.
void change(const EffectParameters& p, int target, ArmModel& model) {
  constexpr double kRadius = 1e-3, kReach = 0.1;  // [m]
  Body& body = model.bodies[target];
  const MassProperties whole = massProperties(body);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(whole.inertia);
  const auto add = [&](double mass, const Eigen::Vector3d& position) {
    Part part;
    part.name = "inertia";
    part.shape = Part::Shape::kSphere;
    part.radius = kRadius;
    part.mass = mass;
    part.position = position;
    body.parts.push_back(part);
  };
  double added = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    // I_a = S_b + S_c with the second moments S, so S_a = tr(I) / 2 - I_a.
    const double moment = 0.5 * principal.eigenvalues().sum() - principal.eigenvalues()[axis];
    const double mass = (p[0] - 1.0) * moment / (2.0 * kReach * kReach);
    for (const double side : {-kReach, kReach}) {
      add(mass, whole.centre_of_mass + side * principal.eigenvectors().col(axis));
    }
    added += 2.0 * mass;
  }
  add(-added, whole.centre_of_mass);
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "inertia-error",
                      .cause = "a body resists turning by another inertia than the model's",
                      .equation = "I' = factor I about the centre of mass",
                      .signature = "joints that are late, or swing too far, in fast movements only",
                      .target = ArmEffect::Target::kMovingBody,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "record slow poses beside fast sines: a mass is felt in both",
                      .needs_motion = true,
                      .change = change};

}  // namespace simgap::arm_effects::inertia_error
