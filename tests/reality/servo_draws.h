/// \file
/// The distribution of position-controlled drives, secrets and magnitudes on which `diagnose` is judged. It was fixed
/// before any rule of the diagnosis was tuned to it; changing it changes what every published rate means.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "reality/servo_rig.h"

namespace simgap::reality {

struct ServoDraw {
  std::vector<std::string> effects;  ///< names of the catalogue; "none"; or "outside: …"
  std::string channel;               ///< outside the catalogue: the channel it depends on
  std::string law = "stribeck";      ///< that is asked
  ServoRig rig;
  ServoSecret secret;
  double magnitude = 0.0;  ///< of the single effect, in its own unit
};

const std::vector<std::string>& servoEffects();
const std::vector<std::string>& servoOutsideKinds();

/// \param mechanism  of the rig; otherwise any.
ServoDraw drawServoNone(std::uint64_t seed, std::optional<Mechanism> mechanism = {});
/// \param effect  of servoEffects(), on a mechanism that can have it. Half of the draws have an expected gain of
/// 5–10 %, half of 10–60 %, as far as the largest magnitude that a real drive has allows.
ServoDraw drawServoEffect(const std::string& effect, std::uint64_t seed);
ServoDraw drawServoPair(std::uint64_t seed);
ServoDraw drawServoOutside(const std::string& kind, std::uint64_t seed);

/// Name and true value of the parameter that an extended model states, where the catalogue's law has the secret's.
std::optional<std::pair<std::string, double>> statedParameter(const ServoDraw& draw);

}  // namespace simgap::reality
