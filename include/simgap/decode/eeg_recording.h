/// \file
/// What was measured at a head, and what its owner was told to do meanwhile.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simgap/core/csv.h"

namespace simgap {

struct EegRecording {
  std::string name;
  std::vector<std::string> channels;
  double rate = 0.0;              ///< [Hz]
  std::vector<double> times;      ///< shape (rows) [s]
  Eigen::MatrixXd volts;          ///< shape (rows, channels)
  std::vector<int> instructions;  ///< shape (rows): +1 up, -1 down, 0 neither; empty: not told
};

/// A recording with fewer has nothing to filter.
inline constexpr std::size_t kFewestEegRows = 64;

/// The words of a recording's labels for the two states.
struct EegLabels {
  std::string up = "up", down = "down";
};

/// Columns `time_s`, a channel per further column with a unit of voltage (`eeg_C3_uV`), and, in a recording to learn
/// from, `label` with the words of `labels`; any other word, and none, is neither.
/// \throws DataError: fewer than two channels or some rows, times that are not even, a label column without either
/// word, and all that CsvTable refuses.
EegRecording readEeg(const CsvTable& table, const EegLabels& labels);

/// Sentences about channels that say nothing, and about times at which none does: a decoder answers there, too, and
/// what it answers is nobody's. \throws DataError: no channel says anything, or they are no EEG's in volts
std::vector<std::string> checkEeg(const EegRecording& recording);

}  // namespace simgap
