/// \file
/// EEG as recorders write it: EDF and EDF+ (Kemp & Olivan 2003) with 16 bits, BioSemi's BDF and BDF+ with 24.
#pragma once

#include <string>
#include <string_view>

#include "simgap/decode/eeg_recording.h"

namespace simgap {

/// Whether a file's first bytes are those of such a recording.
bool isEdf(std::string_view bytes);

/// Every signal in volts is a channel ("EEG C3" is eeg_C3); signals in other units are left out. Annotations with the
/// words of `labels` say what was asked for, as long as they last or, without a duration, until the next one; any other
/// text, and none, is neither. \param name  of the file, for errors
/// \throws DataError: a header that is none, a recording that was not closed or is cut short, one with gaps (EDF+D),
/// fewer than two channels or some rows, channels of different rates, one of the two words alone.
EegRecording readEdf(std::string_view bytes, const std::string& name, const EegLabels& labels);

}  // namespace simgap
