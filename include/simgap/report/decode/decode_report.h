/// \file
/// A trained decoder, and what one says of a recording.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/decode/decoder.h"

namespace simgap {

/// result.json of `decode train`: simgap/decode-train/1.
Json toJson(const Training& training, const EegRecording& recording);
/// result.json of `decode run`: simgap/decode-run/1.
Json toJson(const Decoded& decoded, const EegRecording& recording);
std::string decodeTrainText(const Json& result);
std::string decodeRunText(const Json& result);
/// In a sentence.
std::string decodeTrainAnswer(const Json& result);
std::string decodeRunAnswer(const Json& result);

/// decoded.csv: time_s, probability_up, state, and label where it was told.
std::string decodedCsv(const Decoded& decoded);
/// patterns.csv: per channel, how the strongest directions of the weights sound there; most weight first.
std::string patternsCsv(const Decoder& decoder);

}  // namespace simgap
