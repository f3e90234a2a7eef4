/// \file
/// What the pages of the fit-* commands share.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fit_tables.h"
#include "simgap/report/html/page.h"
#include "simgap/report/html/result_files.h"

namespace simgap {

/// Title and answer from result.json.
Page beginFitPage(const ResultFiles& files);

/// Parameters with intervals, models compared, correlations, and what else the fit has to say.
void addFitDetails(const ResultFiles& files, Page& page);

/// A stretch of the log and what each model predicts for it, by name, the chosen one first; and what that one leaves.
void addTimeChart(const ResultFiles& files, Page& page, const std::vector<double>& time,
                  const std::vector<double>& measured,
                  const std::vector<std::pair<std::string, std::vector<double>>>& predicted);

/// What the models leave, over time, in the colours of their lines.
Chart residualChart(const std::vector<double>& time, const std::vector<double>& measured,
                    const std::vector<std::pair<std::string, std::vector<double>>>& predicted, const std::string& title,
                    std::size_t most = kMostPoints);

/// An extended model fitted anew: measured and predicted over time, and its parameters.
bool isRefit(const ResultFiles& files);
Page refitPage(const ResultFiles& files);

/// The column that is `stem`, or `stem` with a unit. \throws DataError when there is none.
std::string columnLike(const CsvTable& table, std::string_view stem);

/// A line per name in the column `series`, in the order of the file; "measured" as points. \param shown  which rows;
/// all
std::vector<Series> seriesOf(const CsvTable& table, const std::string& x, const std::string& y,
                             const std::function<bool(std::size_t)>& shown = {});

/// A value over two columns of a table, as cells about their distinct values.
Map gridOf(const CsvTable& table, const std::string& x, const std::string& y, const std::vector<double>& value);

}  // namespace simgap
