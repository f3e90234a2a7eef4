/// \file
/// One self-contained HTML page per result: the answer in a sentence, the figures, the tables, where it came from.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"

namespace simgap {

/// A table; cells are text, escaped on writing.
struct PageTable {
  std::string caption;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  bool folded = false;  ///< shown only when opened
};

/// A chart: a Chart.js configuration (type, data, options), drawn by the embedded library.
struct PageChart {
  std::string caption;
  Json config;
};

struct Page {
  std::string title;
  std::string answer;  ///< the result in one sentence
  std::vector<PageTable> tables;
  std::vector<PageChart> charts;
  std::vector<PageTable> details;  ///< below the charts
  std::vector<std::pair<std::string, std::string>> provenance;
};

/// The HTML text; opens from disk, needs no network.
std::string renderPage(const Page& page);

/// \name Chart.js configurations, in colours that colour-blind people can tell apart (Okabe & Ito).
///@{
struct Series {
  std::string name;
  std::vector<double> y;  ///< NaN leaves a gap
};
Json lineChart(const std::vector<double>& x, const std::vector<Series>& series, const std::string& x_title,
               const std::string& y_title, bool logarithmic);
Json barChart(const std::vector<std::string>& labels, const std::vector<Series>& series, const std::string& y_title);
///@}

}  // namespace simgap
