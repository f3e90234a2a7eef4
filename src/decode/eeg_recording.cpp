#include "simgap/decode/eeg_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"

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

std::vector<std::string> checkEeg(const EegRecording& recording) {
  // From one row to the next an EEG goes by some microvolts: less at high rates, more with the mains in it.
  constexpr double kLeastStep = 1e-8, kMostStep = 1e-3;  // [V], of the channel in the middle
  constexpr double kStill = 1.0;                         // [s] of all channels at once
  const Eigen::Index rows = recording.volts.rows(), between = rows - 1;
  const Eigen::MatrixXd steps = recording.volts.bottomRows(between) - recording.volts.topRows(between);
  std::vector<std::string> sentences;
  std::vector<double> sizes;
  for (Eigen::Index c = 0; c < steps.cols(); ++c) {
    const double size = std::sqrt(steps.col(c).squaredNorm() / static_cast<double>(between));
    if (size > 0.0)
      sizes.push_back(size);
    else
      sentences.push_back(fmt::format("{} is constant: nothing was measured there", recording.channels[c]));
  }
  if (sizes.empty()) {
    throw DataError(fmt::format("{}: every channel is constant, expected an EEG: was it connected?", recording.name));
  }
  const double size = upperMedian(sizes);
  if (size < kLeastStep || size > kMostStep) {
    throw DataError(
        fmt::format("{}: from row to row the channels go by {:.2g} uV, expected {:g} to {:g} as of an EEG: is "
                    "the unit in the columns' names right? (--map {}_uV=COLUMN*FACTOR)",
                    recording.name, 1e6 * size, 1e6 * kLeastStep, 1e6 * kMostStep, recording.channels.front()));
  }
  Eigen::Index still = 0, run = 0;
  const auto least = static_cast<Eigen::Index>(kStill * recording.rate);
  for (Eigen::Index i = 0; i < between; ++i) {
    run = (steps.row(i).array() == 0.0).all() ? run + 1 : 0;
    if (run == least) still += least;
    if (run > least) ++still;
  }
  if (still > 0) {
    sentences.push_back(fmt::format("all channels stand still for {:.1f} s: what is decoded there is nobody's",
                                    static_cast<double>(still) / recording.rate));
  }
  return sentences;
}

}  // namespace simgap
