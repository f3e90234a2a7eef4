/// \file
/// A head with sources inside: rhythms that come and go, slow noise, blinks, loose electrodes. What a decoder is tried
/// on.
#pragma once

#include <string>
#include <vector>

namespace simgap::reality {

struct EegDesign {
  int channels = 16;
  double rate = 128.0;   ///< [Hz]
  int trials = 40;       ///< of both states, in drawn order
  double trial_s = 4.0;  ///< each with a pause behind
  double pause_s = 1.0;
  double effect = 0.5;    ///< part by which a rhythm's amplitude falls in its state; 0: nothing is there
  int rhythms = 2;        ///< per state
  int background = 12;    ///< sources that know of no state
  double blinks_s = 6.0;  ///< mean time between blinks; 0: none
  double pops_s = 40.0;   ///< mean time between jumps of an electrode; 0: none
  unsigned seed = 1;
  unsigned head = 1;  ///< draws places and rhythms; `seed` what happens
};

struct EegTable {
  std::vector<std::string> channels;
  std::vector<double> times;               ///< [s]
  std::vector<std::vector<double>> volts;  ///< shape (channels, rows) [uV], rounded to a converter's 0.1 uV
  std::vector<std::string> labels;         ///< "up", "down", "rest"
  std::string csv() const;                 ///< time_s, eeg_<channel>_uV, label
  /// EDF+ (or BDF+) of whole records of a second, 0.1 uV a step, cut at 3276.7 uV; annotations where a label begins,
  /// with or without how long it lasts.
  std::string edf(bool bdf, bool durations) const;
};

EegTable recordEeg(const EegDesign& design);

}  // namespace simgap::reality
