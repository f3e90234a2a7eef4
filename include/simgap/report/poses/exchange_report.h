/// \file
/// What `convert` says about a robot that went from one format into another.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/simulate/robot_exchange.h"

namespace simgap {

/// `simgap/convert/1`
Json toJson(const RobotExchange& exchange);
std::string terminalTable(const RobotExchange& exchange);

}  // namespace simgap
