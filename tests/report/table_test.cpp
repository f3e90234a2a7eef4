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

TEST(Table, NumbersStandToTheRight) {
  EXPECT_EQ(alignedTable(Table{"", {"name", "x"}, {{"a", "1.5"}, {"long", ""}}}), "name    x\na     1.5\nlong\n");
}

}  // namespace
}  // namespace simgap
