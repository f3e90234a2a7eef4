// fit-friction --require: what a log covers, as a user sees it.
#include "cli_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

class CoveredRangeTest : public CliTest {};

TEST_F(CoveredRangeTest, SaysWhatTheLogCovers) {
  succeed({"fit-friction", sourceFile("data/logs/coulomb-offset.csv.gz").string(), "--ratio", "97.74", "--require",
           "paper", "-q", "-o", "fit"});
  const std::string result = text("fit/result.json");
  EXPECT_NE(result.find("requirement, shoulder flexion/extension"), std::string::npos);
  EXPECT_NE(result.find("requirement, elbow flexion/extension"), std::string::npos);
  const CsvTable requirements = CsvTable::parse(text("fit/requirements.csv"), "requirements.csv");
  for (const double share : requirements.quantity("cells_covered", "")) {
    EXPECT_GT(share, 0.1);
    EXPECT_LE(share, 1.0);
  }
  const CsvTable histograms = CsvTable::parse(text("fit/histograms.csv"), "histograms.csv");
  const std::vector<std::string> quantity = histograms.text("quantity");
  const std::vector<double> rows = histograms.quantity("rows", "");
  std::map<std::string, double> sum;
  for (std::size_t i = 0; i < rows.size(); ++i) sum[quantity[i]] += rows[i];
  ASSERT_EQ(sum.size(), 4u);
  const double fitted = Json::parse(result).at("n").get<double>();
  for (const auto& [name, count] : sum) EXPECT_EQ(count, fitted) << name;
  EXPECT_NE(text("fit/report.html").find("How the rows are spread"), std::string::npos);
}

}  // namespace
}  // namespace simgap::test
