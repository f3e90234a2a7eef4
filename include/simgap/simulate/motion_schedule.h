/// \file
/// A movement as a person writes it: steps, ramps, sines and recorded poses per muscle (`simgap/schedule/1`,
/// docs/formats.md), sampled at the ticks of the controllers.
#pragma once

#include <filesystem>
#include <functional>

#include "simgap/core/yaml.h"
#include "simgap/measure/pose_set.h"
#include "simgap/simulate/possible_commands.h"

namespace simgap {

/// \param rate  of the controllers [Hz]
/// \param poses  reads the pose set that the schedule names, when it does
/// \throws ConfigError: an unknown muscle or pose, a muscle without a command, segments whose times go back, a voltage
/// beyond the supply, and all that YamlNode refuses
MotionCommands readSchedule(const YamlNode& root, const ArmModel& model, double rate,
                            const std::function<PoseSet(const std::string& file)>& poses);

}  // namespace simgap
