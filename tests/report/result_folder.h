/// \file
/// Result directories as the commands leave them, filled with known results.
#pragma once

#include "report/known_results.h"
#include "simgap/core/run_directory.h"
#include "simgap/report/html/page.h"
#include "simgap/report/html/result_page.h"
#include "support/files.h"

namespace simgap::test {

/// A result directory that vanishes.
class ResultFolder {
 public:
  explicit ResultFolder(const Json& result)
      : directory_(RunDirectory::create(folder_.path() / "run", /*force=*/false)) {
    RunRecord record({"simgap", "command", "<arm> & more"}, 7, 1);
    record.addInput("model", "arm.yaml", "content");
    record.write(directory_, "done");
    directory_.write("result.json", result);
  }
  explicit ResultFolder(const CalibrationResult& result) : ResultFolder(toJson(result)) {
    directory_.write("history.csv", historyCsv(result));
    directory_.write("parameters.csv", parametersCsv(result));
    directory_.write("errors.csv", errorsCsv(result));
    if (result.uncertainty) directory_.write("singular_values.csv", singularValuesCsv(result));
  }
  explicit ResultFolder(const ValidationResult& result) : ResultFolder(toJson(result)) {
    directory_.write("errors.csv", errorsCsv(result));
  }

  const RunDirectory& directory() const { return directory_; }
  Page page() const { return makePage(ResultFiles(directory_.path())); }

 private:
  TemporaryFolder folder_;
  RunDirectory directory_;
};

/// All charts of a page, in order.
inline std::vector<Chart> chartsOf(const Page& page) {
  std::vector<Chart> charts;
  for (const PageSection& section : page.sections) {
    for (const PageBlock& block : section.blocks) {
      if (const auto* chart = std::get_if<Chart>(&block)) charts.push_back(*chart);
    }
  }
  return charts;
}

inline Chart chartOf(const Page& page, const std::string& caption) {
  for (const Chart& chart : chartsOf(page)) {
    if (chart.caption == caption) return chart;
  }
  return {"there is no chart '" + caption + "'", "", Json::object()};
}

}  // namespace simgap::test
