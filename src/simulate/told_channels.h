/// \file
/// Commands of what is no arm: a few channels, told by the columns of a table or under `joint:` of a schedule.
#pragma once

#include <span>

#include "simgap/core/csv.h"
#include "simgap/core/yaml.h"
#include "simgap/measure/motion_commands.h"

namespace simgap {

/// \param channels  rows of the values that come out \param required  so many of them must be there; others are 0
MotionCommands readToldChannels(const CsvTable& table, std::span<const CommandChannel> channels, std::size_t required,
                                bool linear);
/// A row per tick. \param rate  of the ticks [Hz]  \throws ConfigError
MotionCommands readToldChannels(const YamlNode& root, std::span<const CommandChannel> channels, std::size_t required,
                                double rate);

}  // namespace simgap
