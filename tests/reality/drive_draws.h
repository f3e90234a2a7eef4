/// \file
/// The distribution of benches, secrets and magnitudes on which `diagnose` is judged. It was fixed before the diagnosis
/// was tuned; changing it changes what every published rate means.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "reality/drive_rig.h"

namespace simgap::reality {

struct DriveDraw {
  std::vector<std::string> effects;  ///< names of the catalogue; "none"; or "outside: …"
  std::string channel;               ///< outside the catalogue: the channel it depends on
  double gain = 0.0;                 ///< that a model of the secret is expected to have
  DriveRig rig;
  DriveSecret secret;
  double magnitude = 0.0;  ///< of the single effect, in its own unit
};

/// Names of the effects that can be drawn.
const std::vector<std::string>& drawableEffects();
const std::vector<std::string>& outsideKinds();

DriveRig drawRig(std::uint64_t seed);
DriveDraw drawNone(std::uint64_t seed);
/// \param effect  of drawableEffects(). Half of the draws have an expected gain of 5–10 %, half of 10–60 %.
DriveDraw drawEffect(const std::string& effect, std::uint64_t seed);
DriveDraw drawPair(std::uint64_t seed);
/// Name and true value of the parameter that an extended model states for the secret of `drawEffect`; none where
/// catalogue and reality have different laws (bristles), or refer to different temperatures.
std::optional<std::pair<std::string, double>> statedParameter(const DriveDraw& draw);
DriveDraw drawOutside(const std::string& kind, std::uint64_t seed);

}  // namespace simgap::reality
