/// \file
/// A robot from one file format into another, read back and compared with what it was.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "simgap/exchange/exchange.h"
#include "simgap/simulate/exchange_replay.h"

namespace simgap {

struct RobotFile {
  std::string text;
  std::filesystem::path file;  ///< its name, for messages
};

struct RobotExchange {
  std::filesystem::path from, to;
  RobotFormat from_format = RobotFormat::kArm, to_format = RobotFormat::kArm;
  ArmModel model;
  std::vector<ExchangeRemark> read, written;  ///< of either side
  ExchangeReplay replay;                      ///< `text`, read back
  std::string text;                           ///< what belongs into `to`
};

/// \param muscles  keys muscles, tendons, motor_defaults, gearbox_defaults and extensions of an arm file, whole or not,
///                 which replace those of the robot; no text: its own stay
/// \param read  as readMjcf
/// \throws ConfigError for an arm file or muscles, or an ending of `to`, that cannot be; DataError as readMjcf and
///         readUrdf; NumericsError: what would be written is another robot when it is read back
RobotExchange exchangeRobot(const RobotFile& from, const RobotFile& muscles, const std::filesystem::path& to,
                            const FileReader& read);

}  // namespace simgap
