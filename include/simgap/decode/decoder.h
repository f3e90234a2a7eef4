/// \file
/// Which of two states somebody has in mind, from the covariance of what was measured at the head (Brain-Controlled
/// Exoskeleton Robot for BMI Rehabilitation, section II).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/decode/eeg_recording.h"

namespace simgap {

/// What is done to a recording before covariances are taken.
struct DecoderSettings {
  double low = 7.0, high = 30.0;  ///< band [Hz]
  int order = 4;                  ///< of the band-pass
  double rate = 128.0;            ///< at most so many samples a second are kept [Hz]
  double window = 1.0;            ///< [s] of a covariance; N of eq. (8) is its samples
  double threshold = 0.7;         ///< of the probability that switches, eq. (9)
};

struct Decoder {
  DecoderSettings settings;
  std::vector<std::string> channels;
  double rate = 0.0;        ///< of the recording it was trained on [Hz]
  Eigen::MatrixXd weights;  ///< W, shape (channels, channels) [1/V^2]
  double bias = 0.0;
  double penalty = 0.0;  ///< lambda
};

/// Of a window: its time, covariance [V^2], instruction, and the trial, a stretch of one instruction, that it is of.
struct LabelledCovariance {
  double time;  ///< [s] at its end
  Eigen::MatrixXd covariance;
  int instruction;
  std::size_t trial;
};

/// Filtered, less the mean of all channels, thinned: shape (samples, channels) [V].
struct PreparedEeg {
  Eigen::MatrixXd volts;
  std::vector<std::size_t> rows;  ///< of the recording, one per sample
  double rate;                    ///< [Hz]
};
/// \throws DataError: a band that the recording's rate cannot hold
PreparedEeg prepareEeg(const EegRecording& recording, const DecoderSettings& settings);

/// Windows side by side within each trial; the first window's time of a recording, in which the filter settles, is left
/// out.
std::vector<LabelledCovariance> labelledWindows(const EegRecording& recording, const DecoderSettings& settings);

struct TrainingOptions {
  DecoderSettings settings;
  int folds = 5;  ///< of whole trials, for the accuracy; each chooses its penalty by folds of its own
};

/// Held-out loss of one penalty, as a part of the least one that leaves nothing.
struct PenaltyLoss {
  double part;
  double loss;  ///< mean of ln(1 + exp(-q a)), of windows that were not learnt from
};

struct Training {
  Decoder decoder;
  std::size_t windows = 0, trials = 0, disturbed = 0;  ///< disturbed: not learnt from, but judged
  double accuracy = 0.0, accuracy_half = 0.0;          ///< of held-out windows, by trials; half of its 95 % interval
  double chance = 0.0;                                 ///< what always the same answer reaches
  double loss = 0.0;                                   ///< held out
  std::vector<PenaltyLoss> penalties;
  double gap = 0.0;  ///< of the delivered fit
  Eigen::Index rank = 0;
  bool betterThanChance() const { return accuracy - accuracy_half > chance; }
};
/// \throws DataError: no label column, fewer than two trials of a state per fold, a band that does not fit;
/// NumericsError: the duality gap is not reached; InterruptedError
Training trainDecoder(const EegRecording& recording, const TrainingOptions& options,
                      const std::function<void(double, const char*)>& progress = {});

/// What a recording says, sample by sample.
struct Decoded {
  std::vector<double> times;          ///< [s]
  std::vector<double> probability;    ///< of up, eq. (1)
  std::vector<int> state;             ///< +1 up, -1 down, 0 before the first decision; eq. (9)
  std::vector<int> instruction;       ///< as recorded; empty: not told
  std::optional<double> accuracy;     ///< share of instructed samples with the right side of 0.5
  std::optional<double> state_share;  ///< share of instructed samples in the right state
  std::size_t switches = 0;
};
/// \throws DataError: other channels or another rate than it was trained with
Decoded decode(const Decoder& decoder, const EegRecording& recording);

/// simgap/decoder/1
std::string toYaml(const Decoder& decoder);
Decoder readDecoder(const YamlNode& root);

}  // namespace simgap
