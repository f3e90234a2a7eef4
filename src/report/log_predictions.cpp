#include "simgap/report/log_predictions.h"

#include "simgap/core/csv.h"

namespace simgap {

std::string predictionsCsv(const PreparedLog& log,
                           const std::vector<std::pair<std::string, const Eigen::ArrayXd*>>& predictions) {
  std::vector<std::string> header{"time_s", "measured"};
  for (const auto& [name, values] : predictions) header.push_back(name);
  header.emplace_back("used");
  CsvWriter csv(header);
  for (Eigen::Index i = 0; i < log.data.rows.rows(); ++i) {
    csv.add(log.data.rows.time[i]).add(log.data.rows.effort[i]);
    for (const auto& [name, values] : predictions) csv.add((*values)[i]);
    csv.add(log.data.keep[i] ? 1.0 : 0.0).endRow();
  }
  return csv.text();
}

}  // namespace simgap
