// EEG as recorders write it (EDF+, Kemp & Olivan 2003; BioSemi's BDF+), byte by byte.
#include <algorithm>
#include <cmath>

#include "reality/eeg.h"

namespace simgap::reality {
namespace {

std::string edfField(std::string text, std::size_t length) {
  text.resize(length, ' ');
  return text;
}

std::string littleEndian(long value, std::size_t bytes) {
  std::string text;
  for (std::size_t b = 0; b < bytes; ++b) text += static_cast<char>((value >> (8 * b)) & 0xff);
  return text;
}

}  // namespace

std::string EegTable::edf(bool bdf, bool durations) const {
  constexpr std::size_t kNotes = 60;  // samples of annotations per record
  const auto rate = static_cast<std::size_t>(std::lround(1.0 / (times[1] - times[0])));
  const std::size_t width = bdf ? 3 : 2, count = channels.size(), records = times.size() / rate;
  const std::string steps = bdf ? "8388600" : "32767", range = bdf ? "838860" : "3276.7";
  std::string text = bdf ? std::string("\xff") + edfField("BIOSEMI", 7) : edfField("0", 8);
  text +=
      edfField("X X X X", 80) + edfField("Startdate X X X X", 80) + edfField("01.01.26", 8) + edfField("00.00.00", 8);
  text += edfField(std::to_string(256 * (count + 2)), 8) + edfField(bdf ? "BDF+C" : "EDF+C", 44);
  text += edfField(std::to_string(records), 8) + edfField("1", 8) + edfField(std::to_string(count + 1), 4);
  const auto all = [&](std::size_t length, const auto& of, const std::string& of_notes) {
    for (std::size_t c = 0; c < count; ++c) text += edfField(of(c), length);
    text += edfField(of_notes, length);
  };
  const auto same = [](const std::string& word) { return [word](std::size_t) { return word; }; };
  all(
      16, [&](std::size_t c) { return "EEG " + channels[c]; }, bdf ? "BDF Annotations" : "EDF Annotations");
  all(80, same("electrode"), "");
  all(8, same("uV"), "");
  all(8, same("-" + range), "-1");
  all(8, same(range), "1");
  all(8, same("-" + steps), "-32768");
  all(8, same(steps), "32767");
  all(80, same(""), "");
  all(8, same(std::to_string(rate)), std::to_string(kNotes));
  all(32, same(""), "");
  for (std::size_t r = 0; r < records; ++r) {
    for (const std::vector<double>& channel : volts) {
      for (std::size_t i = r * rate; i < (r + 1) * rate; ++i) {
        text += littleEndian(std::lround(std::clamp(channel[i] / 0.1, -32767.0, 32767.0)), width);
      }
    }
    std::string notes = "+" + std::to_string(r) + "\x14\x14" + std::string(1, '\0');
    for (std::size_t i = r * rate; i < (r + 1) * rate; ++i) {
      if (i > 0 && labels[i] == labels[i - 1]) continue;
      std::size_t end = i;
      while (end < labels.size() && labels[end] == labels[i]) ++end;
      notes += "+" + std::to_string(times[i]);
      if (durations) notes += "\x15" + std::to_string(static_cast<double>(end - i) / static_cast<double>(rate));
      notes += "\x14" + labels[i] + "\x14" + std::string(1, '\0');
    }
    notes.resize(kNotes * width, '\0');
    text += notes;
  }
  return text;
}

}  // namespace simgap::reality
