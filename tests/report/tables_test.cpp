// A result becomes tables once: what the terminal prints are the cells of the page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <variant>

#include "report/result_folder.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

FitSummary knownSummary() {
  FitSummary summary;
  summary.command = "fit-motor";
  summary.model = "stiff";
  summary.target = "force";
  summary.target_unit = "N";
  Estimate found;
  found.name = "k";
  found.unit = "N";
  found.value = 1234.6;
  found.sd = 12.0;
  found.lower95 = 1210.0;
  found.upper95 = 1259.0;
  Estimate known = found, lost = found;
  known.name = "a";
  known.fixed = true;
  lost.name = "b";
  lost.value = lost.sd = lost.lower95 = lost.upper95 = std::nan("");
  lost.identifiable = false;
  summary.uncertainty.estimates = {found, known, lost};
  summary.mse = 4.0;
  summary.comparison = {{"soft", 2, 8.0, 9.0, 12.0}, {"stiff", 3, 4.0, 4.5, 10.0}};
  summary.n = 100;
  summary.starts = 8;
  summary.distinct_minima = 2;
  return summary;
}

Table tableOf(const Page& page, const std::string& caption) {
  for (const PageSection& section : page.sections) {
    for (const PageBlock& block : section.blocks) {
      const auto* table = std::get_if<Table>(&block);
      if (table != nullptr && table->caption.starts_with(caption)) return *table;
    }
  }
  throw std::runtime_error("no table " + caption);
}

TEST(Tables, TerminalAndPageShowTheSameCells) {
  const FitSummary summary = knownSummary();
  const std::string terminal = terminalTable(summary);
  const ResultFolder folder(toJson(summary));
  folder.directory().write("response.csv", std::string_view("time_s,velocity_simulated_rad_s\n0,1\n1,2\n"));
  const Page page = folder.page();
  EXPECT_THAT(terminal, HasSubstr(alignedTable(tableOf(page, "Parameters"))));
  EXPECT_THAT(terminal, HasSubstr(alignedTable(tableOf(page, "Models on the same rows"))));
  EXPECT_THAT(terminal, HasSubstr("8 starts over the whole box, 2 distinct local minima\n"));
}

TEST(Tables, CellsSayWhatIsFixedAndWhatCouldNotBeFound) {
  const ResultFolder folder(toJson(knownSummary()));
  folder.directory().write("response.csv", std::string_view("time_s,velocity_simulated_rad_s\n0,1\n1,2\n"));
  const Table table = tableOf(folder.page(), "Parameters");
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_THAT(table.rows[0], testing::ElementsAre("k", "N", "1235", "12", "1210 … 1259", ""));
  EXPECT_THAT(table.rows[1], testing::ElementsAre("a", "N", "1234.6", "-", "-", "fixed"));
  EXPECT_THAT(table.rows[2], testing::ElementsAre("b", "N", "-", "-", "-", "not determined"));
  EXPECT_THAT(tableOf(folder.page(), "Models").rows[1],
              testing::ElementsAre("stiff *", "3", "4", "4.5", "50.00 %", "50.00 %", "10.0"));
}

}  // namespace
}  // namespace simgap::test
