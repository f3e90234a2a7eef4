/// \file
/// Effects planted into measured logs: a known force, of a drawn size and shape, is added to the measured effort (or
/// the effort is shifted or bent). The motion is the measured one; nothing here is code of the models.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "real/real_logs.h"

namespace simgap::test {

/// Which columns of a log are what.
struct PlantingPlan {
  std::string log;                         ///< name in realLogs()
  std::string effort, position, velocity;  ///< columns; velocity empty: from the position
  std::vector<std::string> effects;        ///< that can be planted there: the law lacks them, the log shows them
  std::size_t every = 1;                   ///< rows that are kept
};

const std::vector<PlantingPlan>& plantingPlans();

/// A log as columns of text and of numbers.
struct LogTable {
  std::vector<std::string> header;
  std::vector<std::vector<double>> columns;

  static LogTable load(const std::filesystem::path& file, std::size_t every);
  std::vector<double>& column(const std::string& name);
  void append(const LogTable& more);  ///< of the same columns
  void save(const std::filesystem::path& file) const;
};

struct Planted {
  LogTable table;
  std::string shape;                                     ///< in words
  double magnitude = 0.0;                                ///< in the unit of the shape
  std::optional<std::pair<std::string, double>> stated;  ///< parameter of the cause and its value, torques in efforts
};

/// \param error  mean squared error of the baseline on the log as it is; \param gain  that a model of the planted
/// effect should have, 0 to 1; \param seed  of size and shape.
Planted plant(const PlantingPlan& plan, const LogTable& log, const std::string& effect, double error, double gain,
              std::uint64_t seed);

/// A signal with the spectrum of `values` and random phases.
std::vector<double> phasesRandomised(const std::vector<double>& values, std::uint64_t seed);

}  // namespace simgap::test
