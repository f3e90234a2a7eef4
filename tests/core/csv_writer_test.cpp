// What is written reads back, and harms no spreadsheet.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "simgap/core/csv.h"

namespace simgap {
namespace {

CsvTable written(const std::string& text) { return CsvTable::parse(text, "log.csv"); }

TEST(CsvRoundTrip, GivesBackEveryNumberBitByBit) {
  std::mt19937 random(7);
  std::uniform_int_distribution<std::uint64_t> bits;
  std::vector<double> numbers = {0.0, -0.0, 0.1, 1.0 / 3.0, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308};
  while (numbers.size() < 20000) {
    const auto number = std::bit_cast<double>(bits(random));
    if (std::isfinite(number)) numbers.push_back(number);
  }
  CsvWriter writer({"x", "negative"});
  for (const double number : numbers) writer.add(number).add(-number).endRow();
  const CsvTable table = written(writer.text());
  const std::vector<double> read = table.quantity("x", "");
  const std::vector<double> negative = table.quantity("negative", "");
  ASSERT_EQ(read.size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(read[i]), std::bit_cast<std::uint64_t>(numbers[i])) << numbers[i];
    ASSERT_EQ(std::bit_cast<std::uint64_t>(negative[i]), std::bit_cast<std::uint64_t>(-numbers[i])) << numbers[i];
  }
}

TEST(CsvRoundTrip, GivesBackEveryText) {
  std::mt19937 random(8);
  constexpr std::string_view kCharacters = "a5,\"\r\n .-\xC3\xA9";
  std::uniform_int_distribution<std::size_t> character(0, kCharacters.size() - 1);
  std::uniform_int_distribution<int> length(0, 6);
  for (const std::size_t columns : {1u, 3u}) {
    std::vector<std::string> header;
    for (std::size_t c = 0; c < columns; ++c) header.push_back("column, \"" + std::to_string(c) + "\"");
    std::vector<std::vector<std::string>> texts(columns);
    CsvWriter writer(header);
    for (int row = 0; row < 2000; ++row) {
      for (std::vector<std::string>& column : texts) {
        std::string text;
        for (int left = length(random); left > 0; --left) text += kCharacters[character(random)];
        writer.add(text);
        column.push_back(text);
      }
      writer.endRow();
    }
    const CsvTable table = written(writer.text());
    for (std::size_t c = 0; c < columns; ++c) EXPECT_EQ(table.text(header[c]), texts[c]) << columns << " columns";
  }
}

TEST(CsvWriter, QuotesOnlyWhatNeedsIt) {
  CsvWriter writer({"a", "b, c"});
  writer.add("plain").add(0.1).endRow().add("").add("say \"hi\"").endRow();
  EXPECT_EQ(writer.text(), "a,\"b, c\"\nplain,0.1\n,\"say \"\"hi\"\"\"\n");
}

// A spreadsheet runs what such a cell holds.
TEST(CsvWriter, DisarmsFormulasAndReadsThemBack) {
  const std::vector<std::string> names = {"=1+1", "+cmd",   "-p1", "@sum",  "'=quoted",
                                          "=a,b", "=\"x\"", "-",   "plain", "-5"};
  CsvWriter writer({"=head", "name"});
  for (const std::string& name : names) writer.add(-1.5).add(name).endRow();
  EXPECT_EQ(writer.text().find(",="), std::string::npos);
  EXPECT_NE(writer.text().find(",'=1+1\n"), std::string::npos);
  EXPECT_NE(writer.text().find(",\"'=a,b\"\n"), std::string::npos);
  EXPECT_NE(writer.text().find(",-5\n"), std::string::npos) << "a number is no formula";
  const CsvTable table = written(writer.text());
  EXPECT_EQ(table.text("name"), names);
  EXPECT_EQ(table.columns().front(), "=head");
  EXPECT_EQ(table.quantity("=head", ""), std::vector<double>(names.size(), -1.5));
}

}  // namespace
}  // namespace simgap
