#include "simgap/decode/edf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr std::string_view kBioSemi =
    "\xff"
    "BIOSEMI";
constexpr std::size_t kFixedHeader = 256, kSignalHeader = 256;  // [bytes]

struct EdfSignal {
  std::string label, unit;
  double physical_lowest = 0.0, physical_highest = 0.0, digital_lowest = 0.0, digital_highest = 0.0;
  std::size_t samples = 0;  ///< per record
  std::size_t begin = 0;    ///< in a record [bytes]
  bool annotations = false;

  double value(double digital) const {
    return physical_lowest +
           (digital - digital_lowest) * (physical_highest - physical_lowest) / (digital_highest - digital_lowest);
  }
};

/// Fields of ASCII, one behind the other.
class EdfHeader {
 public:
  EdfHeader(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  std::string text(std::size_t length) {
    if (at_ + length > bytes_.size()) fail(fmt::format("found {} bytes, expected a whole header", bytes_.size()));
    std::string_view field = bytes_.substr(at_, length);
    at_ += length;
    while (!field.empty() && (field.back() == ' ' || field.back() == '\0')) field.remove_suffix(1);
    while (!field.empty() && field.front() == ' ') field.remove_prefix(1);
    return std::string(field);
  }
  double number(std::size_t length, const std::string& what) {
    const std::size_t from = at_;
    const std::string field = text(length);
    const std::optional<double> value = parseNumber(field);
    if (!value || !std::isfinite(*value)) {
      fail(fmt::format("byte {}: found {} '{}', expected a number", from, what, printable(field)));
    }
    return *value;
  }
  std::size_t count(std::size_t length, const std::string& what, double most) {
    const double value = number(length, what);
    if (!(value >= 0.0 && value <= most && value == std::floor(value))) {
      fail(fmt::format("found {} {:g}, expected a whole number from 0 to {:g}", what, value, most));
    }
    return static_cast<std::size_t>(value);
  }
  [[noreturn]] void fail(const std::string& sentence) const { throw DataError(name_ + ": " + sentence); }

 private:
  static std::string printable(std::string text) {
    std::ranges::replace_if(
        text, [](unsigned char c) { return c < 32 || c > 126; }, '?');
    return text;
  }

  std::string_view bytes_;
  std::string name_;
  std::size_t at_ = 0;
};

struct EdfFile {
  std::vector<EdfSignal> signals;
  std::size_t records = 0, record_bytes = 0, header_bytes = 0, sample_bytes = 2;
  double record_s = 0.0;
  std::string_view bytes;

  std::string_view part(std::size_t record, const EdfSignal& signal) const {
    return bytes.substr(header_bytes + record * record_bytes + signal.begin, signal.samples * sample_bytes);
  }
  /// Little endian, with a sign.
  double sample(std::string_view part, std::size_t i) const {
    long value = 0;
    for (std::size_t b = 0; b < sample_bytes; ++b) {
      value |= static_cast<long>(static_cast<unsigned char>(part[i * sample_bytes + b])) << (8 * b);
    }
    const long half = 1L << (8 * sample_bytes - 1);
    return static_cast<double>(value >= half ? value - 2 * half : value);
  }
};

std::vector<EdfSignal> readSignals(EdfHeader& header, std::size_t count, std::size_t sample_bytes) {
  std::vector<EdfSignal> signals(count);
  for (EdfSignal& s : signals) s.label = header.text(16);
  for (std::size_t i = 0; i < count; ++i) header.text(80);  // kinds of electrodes
  for (EdfSignal& s : signals) s.unit = header.text(8);
  for (EdfSignal& s : signals) s.physical_lowest = header.number(8, "a physical minimum");
  for (EdfSignal& s : signals) s.physical_highest = header.number(8, "a physical maximum");
  for (EdfSignal& s : signals) s.digital_lowest = header.number(8, "a digital minimum");
  for (EdfSignal& s : signals) s.digital_highest = header.number(8, "a digital maximum");
  for (std::size_t i = 0; i < count; ++i) header.text(80);  // filters
  std::size_t begin = 0;
  for (EdfSignal& s : signals) {
    s.samples = header.count(8, "samples per record", 1e6);
    s.begin = begin;
    begin += s.samples * sample_bytes;
    s.annotations = s.label == "EDF Annotations" || s.label == "BDF Annotations";
    if (!s.annotations && !(s.digital_lowest < s.digital_highest && s.physical_lowest != s.physical_highest)) {
      header.fail(fmt::format("signal '{}': found a range of {:g} … {:g} for {:g} … {:g}, expected two that differ",
                              s.label, s.digital_lowest, s.digital_highest, s.physical_lowest, s.physical_highest));
    }
  }
  for (std::size_t i = 0; i < count; ++i) header.text(32);
  return signals;
}

EdfFile readFile(std::string_view bytes, const std::string& name) {
  EdfHeader header(bytes, name);
  EdfFile file;
  file.bytes = bytes;
  file.sample_bytes = bytes.starts_with(kBioSemi) ? 3 : 2;
  header.text(8 + 80 + 80 + 8 + 8);  // version, person, recording, date, time
  file.header_bytes = header.count(8, "bytes of the header", 1e9);
  if (header.text(44).substr(0, 5).ends_with("+D")) {
    header.fail("found a recording with gaps (EDF+D), expected one without (EDF+C): cut it at its gaps");
  }
  const double records = header.number(8, "data records");
  if (records < 0.0) header.fail("found -1 data records, expected their number: the recording was not closed");
  file.record_s = header.number(8, "a record's duration");
  const std::size_t signals = header.count(4, "signals", 4096);
  if (file.header_bytes != kFixedHeader + kSignalHeader * signals) {
    header.fail(fmt::format("found a header of {} bytes for {} signals, expected {}", file.header_bytes, signals,
                            kFixedHeader + kSignalHeader * signals));
  }
  if (!(file.record_s > 0.0)) header.fail("found records without a duration, expected signals over time");
  file.signals = readSignals(header, signals, file.sample_bytes);
  for (const EdfSignal& s : file.signals) file.record_bytes += s.samples * file.sample_bytes;
  const std::size_t left = bytes.size() - file.header_bytes;
  if (file.record_bytes == 0 || records > static_cast<double>(left / file.record_bytes)) {
    header.fail(fmt::format("found {} bytes behind the header, expected {:g} records of {}: the file is cut short",
                            left, records, file.record_bytes));
  }
  file.records = static_cast<std::size_t>(records);
  return file;
}

/// Volts per unit of a signal; 0: it is no voltage.
double voltsPer(const std::string& unit) {
  if (unit == "V") return 1.0;
  if (unit == "mV") return 1e-3;
  const bool micro = unit.size() >= 2 && unit.back() == 'V' &&
                     (unit == "uV" || unit == "\xb5V" || unit == "\xc2\xb5V" || unit == "\xce\xbcV");
  return micro ? 1e-6 : 0.0;
}

/// "EEG C3" as a table would call it: eeg_C3.
std::string channelName(std::string label) {
  if (label.starts_with("EEG ")) label.replace(0, 4, "eeg_");
  std::ranges::replace(label, ' ', '_');
  return label;
}

struct Annotation {
  double onset = 0.0, duration = -1.0;  ///< [s]; -1: until the next one
  std::string text;
};

/// Lists "+onset[\x15duration]\x14text\x14…\x14\0", packed into a signal.
void readAnnotations(std::string_view part, std::vector<Annotation>& found) {
  while (!part.empty()) {
    const std::size_t end = std::min(part.find('\0'), part.size());
    std::string_view list = part.substr(0, end);
    part.remove_prefix(std::min(end + 1, part.size()));
    std::size_t next = list.find('\x14');
    if (next == std::string_view::npos) continue;
    std::string_view time = list.substr(0, next);
    if (time.starts_with('+')) time.remove_prefix(1);
    const std::size_t mark = time.find('\x15');
    const std::optional<double> onset = parseNumber(time.substr(0, mark));
    const std::optional<double> lasts =
        mark == std::string_view::npos ? std::nullopt : parseNumber(time.substr(mark + 1));
    for (list.remove_prefix(next + 1); onset && (next = list.find('\x14')) != std::string_view::npos;
         list.remove_prefix(next + 1)) {
      if (next > 0) found.push_back({*onset, lasts.value_or(-1.0), std::string(list.substr(0, next))});
    }
  }
}

std::vector<int> instructionsOfEdf(const EdfFile& file, const EegRecording& recording, const EegLabels& labels) {
  std::vector<Annotation> annotations;
  for (const EdfSignal& signal : file.signals) {
    for (std::size_t r = 0; signal.annotations && r < file.records; ++r)
      readAnnotations(file.part(r, signal), annotations);
  }
  std::ranges::stable_sort(annotations, {}, &Annotation::onset);
  const auto said = [&](const std::string& word) {
    return std::ranges::find(annotations, word, &Annotation::text) != annotations.end();
  };
  if (!said(labels.up) && !said(labels.down)) return {};
  for (const std::string& word : {labels.up, labels.down}) {
    if (!said(word)) {
      throw DataError(
          fmt::format("{}: annotations: found no '{}' (--up and --down name the two words)", recording.name, word));
    }
  }
  std::vector<int> instructions(recording.times.size(), 0);
  for (std::size_t a = 0; a < annotations.size(); ++a) {
    const Annotation& now = annotations[a];
    const double next = a + 1 < annotations.size() ? annotations[a + 1].onset : kInfinity;
    const double end = now.duration >= 0.0 ? now.onset + now.duration : next;
    const int q = now.text == labels.up ? 1 : now.text == labels.down ? -1 : 0;
    if (q == 0) continue;
    const auto first = std::ranges::lower_bound(recording.times, now.onset - 1e-9) - recording.times.begin();
    const auto last = std::ranges::lower_bound(recording.times, end - 1e-9) - recording.times.begin();
    if (first < last) std::fill(instructions.begin() + first, instructions.begin() + last, q);
  }
  return instructions;
}

}  // namespace

bool isEdf(std::string_view bytes) { return bytes.starts_with("0       ") || bytes.starts_with(kBioSemi); }

EegRecording readEdf(std::string_view bytes, const std::string& name, const EegLabels& labels) {
  const EdfFile file = readFile(bytes, name);
  std::vector<const EdfSignal*> channels;
  for (const EdfSignal& signal : file.signals) {
    if (!signal.annotations && voltsPer(signal.unit) > 0.0) channels.push_back(&signal);
  }
  if (channels.size() < 2) {
    throw DataError(
        fmt::format("{}: found {} channels, expected two or more signals in uV, mV or V", name, channels.size()));
  }
  EegRecording recording;
  recording.name = name;
  const std::size_t samples = channels.front()->samples, rows = samples * file.records;
  if (rows < kFewestEegRows) {
    throw DataError(fmt::format("{}: found {} rows, expected {} or more", name, rows, kFewestEegRows));
  }
  recording.rate = static_cast<double>(samples) / file.record_s;
  for (std::size_t i = 0; i < rows; ++i) recording.times.push_back(static_cast<double>(i) / recording.rate);
  recording.volts.resize(rows, std::ssize(channels));
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const EdfSignal& signal = *channels[c];
    recording.channels.push_back(channelName(signal.label));
    if (signal.samples != samples) {
      throw DataError(fmt::format("{}: found {} samples per record of '{}' and {} of '{}', expected one rate", name,
                                  samples, channels.front()->label, signal.samples, signal.label));
    }
    if (std::ranges::count(recording.channels, recording.channels.back()) > 1) {
      throw DataError(fmt::format("{}: found two channels '{}', expected names of their own", name, signal.label));
    }
    const double volts = voltsPer(signal.unit);
    for (std::size_t r = 0; r < file.records; ++r) {
      const std::string_view part = file.part(r, signal);
      for (std::size_t i = 0; i < samples; ++i) {
        recording.volts(static_cast<Eigen::Index>(r * samples + i), static_cast<Eigen::Index>(c)) =
            volts * signal.value(file.sample(part, i));
      }
    }
  }
  recording.instructions = instructionsOfEdf(file, recording, labels);
  return recording;
}

}  // namespace simgap
