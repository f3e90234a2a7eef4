// EDF, EDF+ and BDF, as tests/reality writes them byte by byte: read as the table with the same numbers would be.
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
      const std::string bytes = table.edf(bdf, durations);
      ASSERT_TRUE(isEdf(bytes));
      expectSameRecording(readEdf(bytes, "head.edf", {}), expected);
    }
  }
  EXPECT_FALSE(isEdf(table.csv()));
}

TEST(Edf, SaysWhatIsWrong) {
  const std::string bytes = smallHead().edf(false, true);
  const auto refusal = [](const std::string& text, const EegLabels& labels = {}) {
    return errorOf([&] { readEdf(text, "head.edf", labels); });
  };
  EXPECT_THAT(refusal(bytes.substr(0, 300)), HasSubstr("head.edf: found 300 bytes, expected a whole header"));
  EXPECT_THAT(refusal(bytes.substr(0, bytes.size() - 1)), HasSubstr("the file is cut short"));
  std::string text = bytes;
  text.replace(236, 8, "-1      ");
  EXPECT_THAT(refusal(text), HasSubstr("the recording was not closed"));
  text = bytes;
  text.replace(192, 5, "EDF+D");
  EXPECT_THAT(refusal(text), HasSubstr("a recording with gaps"));
  text = bytes;
  text.replace(252, 4, "many");
  EXPECT_THAT(refusal(text), HasSubstr("byte 252: found signals 'many', expected a number"));
  EXPECT_THAT(refusal(replaced(replaced(bytes, "uV      ", "degC    "), "uV      ", "degC    ")),
              HasSubstr("found 1 channels, expected two or more signals"));
  EXPECT_THAT(refusal(bytes, {"up", "below"}), HasSubstr("found no 'below' (--up and --down"));
  EXPECT_TRUE(readEdf(bytes, "head.edf", {"above", "below"}).instructions.empty());
}

}  // namespace
}  // namespace simgap::test
