#include "simgap/decode/eeg_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr double kMostJitter = 0.5;  // of a sample time: more is a gap, over which a filter would ring

/// Channels: every column of voltage, by its stem.
std::vector<std::string> channelsOf(const CsvTable& table) {
  const std::vector<std::string> volts = unitsLike("V");
  std::vector<std::string> channels;
  for (const std::string& column : table.columns()) {
    const UnitName name = splitUnit(column);
    if (std::ranges::find(volts, name.unit) != volts.end()) channels.push_back(name.stem);
  }
  if (channels.size() < 2) {
    throw DataError(fmt::format("{}: found {} channels, expected two or more columns such as eeg_C3_uV (units: {})",
                                table.name(), channels.size(), fmt::join(volts, ", ")));
  }
  return channels;
}

double evenRate(const CsvTable& table, const std::vector<double>& times) {
  if (times.size() < kFewestEegRows) {
    throw DataError(fmt::format("{}: found {} rows, expected {} or more", table.name(), times.size(), kFewestEegRows));
  }
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  if (!(step > 0.0)) throw DataError(fmt::format("{}: time_s does not increase", table.name()));
  for (std::size_t row = 1; row < times.size(); ++row) {
    const double found = times[row] - times[row - 1];
    if (!(std::abs(found - step) <= kMostJitter * step)) {
      table.fail(row, fmt::format("time_s: found a step of {:.4g} s, expected even ones of {:.4g} s: cut the recording "
                                  "at its gaps",
                                  found, step));
    }
  }
  return 1.0 / step;
}

std::vector<int> instructionsOf(const CsvTable& table, const EegLabels& labels) {
  if (!table.has("label")) return {};
  std::vector<int> instructions;
  for (const std::string& word : table.text("label")) {
    instructions.push_back(word == labels.up ? 1 : word == labels.down ? -1 : 0);
  }
  for (const int q : {1, -1}) {
    if (std::ranges::find(instructions, q) != instructions.end()) continue;
    throw DataError(fmt::format("{}: column label: found no '{}' (--up and --down name the two words)", table.name(),
                                q > 0 ? labels.up : labels.down));
  }
  return instructions;
}

}  // namespace

EegRecording readEeg(const CsvTable& table, const EegLabels& labels) {
  EegRecording recording;
  recording.name = table.name();
  recording.channels = channelsOf(table);
  recording.times = table.quantity("time", "s");
  recording.rate = evenRate(table, recording.times);
  recording.volts.resize(std::ssize(recording.times), std::ssize(recording.channels));
  for (std::size_t c = 0; c < recording.channels.size(); ++c) {
    const std::vector<double> volts = table.quantity(recording.channels[c], "V");
    recording.volts.col(c) = Eigen::Map<const Eigen::VectorXd>(volts.data(), std::ssize(volts));
  }
  recording.instructions = instructionsOf(table, labels);
  return recording;
}

}  // namespace simgap
