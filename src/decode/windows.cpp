/// From a recording to covariances.
#include <fmt/format.h>

#include <cmath>

#include "simgap/core/error.h"
#include "simgap/decode/band_pass.h"
#include "simgap/decode/decoder.h"

namespace simgap {

PreparedEeg prepareEeg(const EegRecording& recording, const DecoderSettings& settings) {
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::floor(recording.rate / settings.rate + 1e-6)));
  PreparedEeg prepared;
  prepared.rate = recording.rate / static_cast<double>(stride);
  if (!(prepared.rate > 2.0 * settings.high)) {
    throw DataError(fmt::format("{}: found {:.4g} samples a second, expected more than {:g} for a band up to {:g} Hz",
                                recording.name, prepared.rate, 2.0 * settings.high, settings.high));
  }
  const Eigen::Index channels = recording.volts.cols();
  for (Eigen::Index row = 0; row < recording.volts.rows(); row += static_cast<Eigen::Index>(stride)) {
    prepared.rows.push_back(static_cast<std::size_t>(row));
  }
  prepared.volts.resize(std::ssize(prepared.rows), channels);
  for (Eigen::Index c = 0; c < channels; ++c) {
    BandPass filter(settings.order, settings.low, settings.high, recording.rate);
    for (Eigen::Index row = 0; row < recording.volts.rows(); ++row) {
      const double value = filter(recording.volts(row, c));
      if (row % static_cast<Eigen::Index>(stride) == 0)
        prepared.volts(row / static_cast<Eigen::Index>(stride), c) = value;
    }
  }
  prepared.volts.colwise() -= prepared.volts.rowwise().mean().eval();
  return prepared;
}

std::vector<LabelledCovariance> labelledWindows(const EegRecording& recording, const DecoderSettings& settings) {
  const PreparedEeg eeg = prepareEeg(recording, settings);
  const auto length = static_cast<std::size_t>(std::lround(settings.window * eeg.rate));
  std::vector<LabelledCovariance> windows;
  std::size_t trial = 0, inside = 0;  // samples since the trial or the last window began
  for (std::size_t i = length; i < eeg.rows.size(); ++i) {
    const int now = recording.instructions[eeg.rows[i]];
    if (now != recording.instructions[eeg.rows[i - 1]]) {
      ++trial;
      inside = 0;
    }
    if (now == 0 || ++inside < length) continue;
    inside = 0;
    const auto rows = eeg.volts.middleRows(i + 1 - length, length);
    windows.push_back(
        {recording.times[eeg.rows[i]], rows.transpose() * rows / static_cast<double>(length), now, trial});
  }
  return windows;
}

}  // namespace simgap
