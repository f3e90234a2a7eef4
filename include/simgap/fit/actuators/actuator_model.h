/// \file
/// The model of an actuator as a user has it: by name, or from a file, with the effects that extend it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "simgap/fit/actuators/actuator_regression.h"
#include "simgap/model/actuator/fitted_model.h"

namespace simgap {

/// A model as the user has it.
struct ActuatorModel {
  ActuatorBase base;
  std::vector<const ActuatorEffect*> effects;  ///< of its extensions
  std::vector<Estimate> values;                ///< as the file holds them; empty for a law alone
  std::vector<Extension> of_angles = {};       ///< extensions that say nothing about the effort: of the transmission

  /// What the values say of it, as ActuatorRegression takes it.
  std::optional<double> presliding() const;
};

/// A muscle's spring is an effect on top of 002 eq. 14, the inertia of a gearbox one on top of Coulomb friction.
/// \throws ConfigError: an unknown law or effect, a parameter that an effect does not have.
ActuatorModel subjectOf(const FittedModel& model);
/// A friction law, "motor", "gearbox" or "pam". \throws ConfigError: an unknown name.
ActuatorModel subjectOf(std::string_view name);

/// What an extended model predicts for a log, shape (rows).
Eigen::ArrayXd predictExtended(const ActuatorModel& subject, const ActuatorData& data);

}  // namespace simgap
