#include "simgap/report/table.h"

#include <gtest/gtest.h>

#include "simgap/core/csv.h"

namespace simgap {
namespace {

TEST(Table, HoldsRecordsAsFilesDo) {
  const Json records = {{{"name", "a \"b\""}, {"value", 0.1}, {"known", true}},
                        {{"name", "c"}, {"value", nullptr}, {"count", 3}}};
  const Table table = recordTable("Records", records, {"name", "value", "known", "count"});
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"a \"b\"", "0.1", "true", ""}));
  EXPECT_EQ(table.rows[1], (std::vector<std::string>{"c", "", "", "3"}));
  const CsvTable csv = CsvTable::parse(csvText(table), "records.csv");
  EXPECT_EQ(csv.columns(), table.header);
  EXPECT_EQ(csv.text("name"), (std::vector<std::string>{"a \"b\"", "c"}));
}

TEST(Table, WhatIsUnknownIsADash) {
  EXPECT_EQ(numberText(1.25, "{:.1f}"), "1.2");
  EXPECT_EQ(numberText(nullptr, "{:.1f}"), "-");
  EXPECT_EQ(numberText(std::nan(""), "{:.1f}"), "-");
  EXPECT_EQ(degreesCell(nullptr), "-");
}

TEST(Table, NothingHasNoSign) {
  EXPECT_EQ(numberText(-0.3, "{:.0f}"), "0");
  EXPECT_EQ(numberText(-0.001, "{:.2f} m/s"), "0.00 m/s");
  EXPECT_EQ(numberText(-0.04, "{:.2f}"), "-0.04");
  EXPECT_EQ(numberText(-2e-12, "{:.1g}"), "-2e-12");
}

TEST(Table, FitsIntoEightyColumns) {
  const std::string words = "a cell of many words that would not fit beside the others if it stood on one line alone";
  EXPECT_EQ(alignedTable(Table{"", {"name", "x", "what"}, {{"a", "1", words}}}),
            "name  x                                                                     what\n"
            "a     1    a cell of many words that would not fit beside the others if it stood\n"
            "                                                               on one line alone\n");
  const std::string wide(40, 'w');
  EXPECT_EQ(alignedTable(Table{"", {"name", "x", "y"}, {{"a", wide, wide}}}),
            "name  " + std::string(39, ' ') + "x\na     " + wide + "\n\nname  " + std::string(39, ' ') + "y\na     " +
                wide + "\n");
}

TEST(Table, UnitsAsPeopleWriteThem) {
  const std::vector<std::pair<std::string, std::string>> known = {
      {"rad_s", "rad/s"}, {"1_rad", "1/rad"}, {"A2", "A²"},     {"kg_m2", "kg m²"},       {"Nm_A", "N m/A"},
      {"m_s2", "m/s²"},   {"ohm", "Ω"},       {"deg2", "deg²"}, {"Nms_rad", "N m s/rad"}, {"", ""}};
  for (const auto& [unit, title] : known) EXPECT_EQ(unitTitle(unit), title) << unit;
  EXPECT_EQ(probabilityText(0.0), "< 0.0001");
  EXPECT_EQ(probabilityText(0.031), "0.031");
}

TEST(Table, NumbersStandToTheRight) {
  EXPECT_EQ(alignedTable(Table{"", {"name", "x"}, {{"a", "1.5"}, {"long", ""}}}), "name    x\na     1.5\nlong\n");
}

}  // namespace
}  // namespace simgap
