/// \file
/// How the known constants of a bench change.
#pragma once

#include <fmt/format.h>

#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"

namespace simgap {

/// Adds to a constant of the bench, in all its sessions; to one that is fitted when the models are asked.
/// \throws ConfigError: a mass, length or inertia below nothing; a fitted length, or mass beside one, of which only
/// products with others are known.
inline void changeConstant(LogSetting& setting, BenchConstant BenchConstants::*constant, double by, const char* name) {
  Bench& bench = setting.bench;
  const auto add = [&](BenchConstants& constants) {
    double& value = (constants.*constant).value;
    if (constant != &BenchConstants::angle_offset && value + by < 0.0) {
      throw ConfigError(
          fmt::format("found a change of {} by {:g} where the bench has {:g}, expected one that leaves no "
                      "less than nothing",
                      name, by, value));
    }
    value += by;
  };
  if (!(bench.*constant).fitted) {
    add(bench);
    for (auto& [session, constants] : bench.sessions) add(constants);
    return;
  }
  if (constant == &BenchConstants::length || (constant == &BenchConstants::mass && bench.fitsWholeInertia())) {
    throw ConfigError(fmt::format(
        "found a change of {}, of which the bench lets only a product be fitted; expected its value there", name));
  }
  setting.added[name] += by;
}

}  // namespace simgap
