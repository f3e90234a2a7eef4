// EDF, EDF+ and BDF: written here byte by byte, read as the table with the same numbers would be.
#include "simgap/decode/edf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "reality/eeg.h"
#include "simgap/core/error.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

std::string edfField(std::string text, std::size_t length) {
  text.resize(length, ' ');
  return text;
}

std::string littleEndian(long value, std::size_t bytes) {
  std::string text;
  for (std::size_t b = 0; b < bytes; ++b) text += static_cast<char>((value >> (8 * b)) & 0xff);
  return text;
}

/// What a recorder writes of a table: records of a second, 0.1 uV a step, annotations where a label begins.
std::string edfOf(const reality::EegTable& table, std::size_t rate, bool bdf, bool durations) {
  constexpr std::size_t kNotes = 60;  // samples of annotations per record
  const std::size_t width = bdf ? 3 : 2, channels = table.channels.size(), records = table.times.size() / rate;
  const std::string steps = bdf ? "8388600" : "32767", volts = bdf ? "838860" : "3276.7";
  std::string text = bdf ? std::string("\xff") + edfField("BIOSEMI", 7) : edfField("0", 8);
  text +=
      edfField("X X X X", 80) + edfField("Startdate X X X X", 80) + edfField("01.01.26", 8) + edfField("00.00.00", 8);
  text += edfField(std::to_string(256 * (channels + 2)), 8) + edfField(bdf ? "BDF+C" : "EDF+C", 44);
  text += edfField(std::to_string(records), 8) + edfField("1", 8) + edfField(std::to_string(channels + 1), 4);
  const auto all = [&](std::size_t length, const auto& of, const std::string& of_notes) {
    for (std::size_t c = 0; c < channels; ++c) text += edfField(of(c), length);
    text += edfField(of_notes, length);
  };
  const auto same = [](const std::string& word) { return [word](std::size_t) { return word; }; };
  all(
      16, [&](std::size_t c) { return "EEG " + table.channels[c]; }, bdf ? "BDF Annotations" : "EDF Annotations");
  all(80, same("electrode"), "");
  all(8, same("uV"), "");
  all(8, same("-" + volts), "-1");
  all(8, same(volts), "1");
  all(8, same("-" + steps), "-32768");
  all(8, same(steps), "32767");
  all(80, same(""), "");
  all(8, same(std::to_string(rate)), std::to_string(kNotes));
  all(32, same(""), "");
  for (std::size_t r = 0; r < records; ++r) {
    for (const std::vector<double>& channel : table.volts) {
      for (std::size_t i = r * rate; i < (r + 1) * rate; ++i) {
        text += littleEndian(std::lround(std::clamp(channel[i] / 0.1, -32767.0, 32767.0)), width);
      }
    }
    std::string notes = "+" + std::to_string(r) + "\x14\x14" + std::string(1, '\0');
    for (std::size_t i = r * rate; i < (r + 1) * rate; ++i) {
      if (i > 0 && table.labels[i] == table.labels[i - 1]) continue;
      std::size_t end = i;
      while (end < table.labels.size() && table.labels[end] == table.labels[i]) ++end;
      notes += "+" + std::to_string(table.times[i]);
      if (durations) notes += "\x15" + std::to_string(static_cast<double>(end - i) / static_cast<double>(rate));
      notes += "\x14" + table.labels[i] + "\x14" + std::string(1, '\0');
    }
    notes.resize(kNotes * width, '\0');
    text += notes;
  }
  return text;
}

reality::EegTable smallHead() {
  return reality::recordEeg({.channels = 3, .rate = 64.0, .trials = 6, .trial_s = 3.0, .pause_s = 1.0});
}

void expectSameRecording(const EegRecording& found, const EegRecording& table) {
  ASSERT_LE(found.times.size(), table.times.size());
  ASSERT_GT(found.times.size(), table.times.size() - 64);
  EXPECT_EQ(found.channels, table.channels);
  EXPECT_DOUBLE_EQ(found.rate, 64.0);
  const auto rows = static_cast<Eigen::Index>(found.times.size());
  EXPECT_LT((found.volts - table.volts.topRows(rows)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(found.instructions, std::vector<int>(table.instructions.begin(), table.instructions.begin() + rows));
}

TEST(Edf, IsReadAsTheTableWithItsNumbers) {
  reality::EegTable table = smallHead();
  for (auto& channel : table.volts) {
    for (double& volt : channel) volt = std::clamp(volt, -3276.7, 3276.7);
  }
  const EegRecording expected = readEeg(CsvTable::parse(table.csv(), "head.csv"), {});
  for (const bool bdf : {false, true}) {
    for (const bool durations : {false, true}) {
      const std::string bytes = edfOf(table, 64, bdf, durations);
      ASSERT_TRUE(isEdf(bytes));
      expectSameRecording(readEdf(bytes, "head.edf", {}), expected);
    }
  }
  EXPECT_FALSE(isEdf(table.csv()));
}

TEST(Edf, SaysWhatIsWrong) {
  const std::string bytes = edfOf(smallHead(), 64, false, true);
  const auto refusal = [](const std::string& text, const EegLabels& labels = {}) {
    return errorOf([&] { readEdf(text, "head.edf", labels); });
  };
  EXPECT_THAT(refusal(bytes.substr(0, 300)), HasSubstr("head.edf: found 300 bytes, expected a whole header"));
  EXPECT_THAT(refusal(bytes.substr(0, bytes.size() - 1)), HasSubstr("the file is cut short"));
  std::string text = bytes;
  text.replace(236, 8, edfField("-1", 8));
  EXPECT_THAT(refusal(text), HasSubstr("the recording was not closed"));
  text = bytes;
  text.replace(192, 5, "EDF+D");
  EXPECT_THAT(refusal(text), HasSubstr("a recording with gaps"));
  text = bytes;
  text.replace(252, 4, edfField("many", 4));
  EXPECT_THAT(refusal(text), HasSubstr("byte 252: found signals 'many', expected a number"));
  EXPECT_THAT(refusal(replaced(replaced(bytes, "uV      ", "degC    "), "uV      ", "degC    ")),
              HasSubstr("found 1 channels, expected two or more signals"));
  EXPECT_THAT(refusal(bytes, {"up", "below"}), HasSubstr("found no 'below' (--up and --down"));
  EXPECT_TRUE(readEdf(bytes, "head.edf", {"above", "below"}).instructions.empty());
}

}  // namespace
}  // namespace simgap::test
