/// What a recording says, sample by sample.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/decode/decoder.h"

namespace simgap {
namespace {

constexpr double kSameRate = 1e-3;

void requireSame(const Decoder& decoder, const EegRecording& recording) {
  if (recording.channels != decoder.channels) {
    throw DataError(fmt::format("{}: found the channels {}, expected those of the decoder, {}", recording.name,
                                fmt::join(recording.channels, ", "), fmt::join(decoder.channels, ", ")));
  }
  if (std::abs(recording.rate / decoder.rate - 1.0) > kSameRate) {
    throw DataError(fmt::format("{}: found {:.6g} samples a second, expected {:.6g} as the decoder was trained with",
                                recording.name, recording.rate, decoder.rate));
  }
}

/// The shares of instructed samples on the right side, and in the right state.
void compare(Decoded& decoded) {
  double told = 0.0, right = 0.0, right_state = 0.0;
  for (std::size_t i = 0; i < decoded.times.size(); ++i) {
    const int asked = decoded.instruction[i];
    if (asked == 0) continue;
    told += 1.0;
    right += (decoded.probability[i] > 0.5 ? 1 : -1) == asked;
    right_state += decoded.state[i] == asked;
  }
  if (told == 0.0) return;
  decoded.accuracy = right / told;
  decoded.state_share = right_state / told;
}

}  // namespace

Decoded decode(const Decoder& decoder, const EegRecording& recording) {
  requireSame(decoder, recording);
  const PreparedEeg eeg = prepareEeg(recording, decoder.settings);
  const double n = decoder.settings.window * eeg.rate;
  const auto settling = static_cast<Eigen::Index>(std::lround(n));  // of the filter and of the mean
  Decoded decoded;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(eeg.volts.cols(), eeg.volts.cols());
  int state = 0;
  for (Eigen::Index i = 0; i < eeg.volts.rows(); ++i) {
    if (i % 1024 == 0) stopIfInterrupted();
    // (8): C_1 = x^T x, C_t = x^T x / N + (N - 1) / N C_t-1
    const auto x = eeg.volts.row(i);
    if (i == 0) {
      covariance.noalias() = x.transpose() * x;
    } else {
      covariance *= (n - 1.0) / n;
      covariance.noalias() += x.transpose() * x / n;
    }
    if (i < settling) continue;
    // (1)-(3)
    const double log_odds = decoder.weights.cwiseProduct(covariance).sum() + decoder.bias;
    const double up = 1.0 / (1.0 + std::exp(-log_odds));
    // (9): the state stays until the other one is likely enough.
    const int next = up > decoder.settings.threshold ? 1 : 1.0 - up > decoder.settings.threshold ? -1 : state;
    decoded.switches += state != 0 && next != state;
    state = next;
    decoded.times.push_back(recording.times[eeg.rows[i]]);
    decoded.probability.push_back(up);
    decoded.state.push_back(state);
    if (!recording.instructions.empty()) decoded.instruction.push_back(recording.instructions[eeg.rows[i]]);
  }
  if (decoded.times.empty()) {
    throw DataError(fmt::format("{}: found {} samples, expected more than the {} of a window", recording.name,
                                eeg.volts.rows(), settling));
  }
  if (!decoded.instruction.empty()) compare(decoded);
  return decoded;
}

}  // namespace simgap
