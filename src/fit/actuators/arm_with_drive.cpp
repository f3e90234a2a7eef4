#include "simgap/fit/actuators/arm_with_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace simgap {
namespace {

struct ArmKey {
  const char* parameter;
  const char* key;  ///< below muscles.NAME; empty when a calibration cannot search it
};
constexpr ArmKey kArmKeys[] = {{"R", "motor.resistance_ohm"},
                               {"L", "motor.inductance_H"},
                               {"K_E", "motor.back_emf_constant_Vs"},
                               {"K_T", "motor.torque_constant_Nm_A"},
                               {"J_M", "motor.inertia_kg_m2"},
                               {"mu_M", "motor.viscous_friction_Nms"},
                               {"tau_CM", "motor.coulomb_friction_Nm"},
                               {"eta", "gearbox.efficiency"},
                               {"mu_G", "gearbox.viscous_friction_Nms"},
                               {"tau_CG", "gearbox.coulomb_friction_Nm"},
                               {"stiffness", "shock_cord.stiffness_N_m"},
                               {"damping", "shock_cord.damping_Ns_m"},
                               {"rest_length", "shock_cord.rest_length_m"}};

}  // namespace

ArmModel withMotor(const ArmWithDrive& target, const Motor& motor) {
  ArmModel arm = target.arm;
  Motor& own = arm.muscles[target.muscle].motor;
  const double supply = own.supply_voltage;
  own = motor;
  own.supply_voltage = supply;
  return arm;
}

ArmModel withGearbox(const ArmWithDrive& target, const Gearbox& gearbox) {
  ArmModel arm = target.arm;
  arm.muscles[target.muscle].gearbox = gearbox;
  return arm;
}

std::string calibrationParameters(const std::string& muscle, const Uncertainty& uncertainty) {
  std::string text =
      "# For the `parameters:` of a calibration config; the covariance stands in model.yaml.\nparameters:\n";
  for (const Estimate& e : uncertainty.estimates) {
    const auto key = std::ranges::find_if(kArmKeys, [&](const ArmKey& k) { return e.name == k.parameter; });
    if (key == std::end(kArmKeys) || e.fixed || !std::isfinite(e.sd) || e.sd <= 0.0) continue;
    text += fmt::format("  - {{pattern: \"muscles.{}.{}\", step: {:.6g}, prior_sd: {:.6g}}}\n", muscle, key->key, e.sd,
                        e.sd);
  }
  return text;
}

}  // namespace simgap
