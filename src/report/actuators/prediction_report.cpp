#include "simgap/report/actuators/prediction_report.h"

#include <fmt/format.h>

#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/core/units.h"

namespace simgap {

Json toJson(const Prediction& p, const std::string& kind) {
  const std::optional<double> rms = rmsError(p);
  return {{"format", "simgap/predict/1"}, {"model", kind},         {"predicts", quantityName(p.name, p.unit)},
          {"rows", p.predicted.size()},   {"left_out", p.refused}, {"rms_error", rms ? Json(*rms) : Json(nullptr)}};
}

std::string predictionCsv(const Prediction& p) {
  std::vector<std::string> header;
  if (!p.time.empty()) header.emplace_back("time_s");
  header.push_back(quantityName(p.name + "_predicted", p.unit));
  if (!p.measured.empty()) header.push_back(quantityName(p.name + "_measured", p.unit));
  CsvWriter csv(header);
  for (std::size_t i = 0; i < p.predicted.size(); ++i) {
    if (!p.time.empty()) csv.add(p.time[i]);
    std::isfinite(p.predicted[i]) ? csv.add(p.predicted[i]) : csv.add("");
    if (!p.measured.empty()) csv.add(p.measured[i]);
    csv.endRow();
  }
  return csv.text();
}

std::string terminalTable(const Prediction& p, const std::string& file) {
  std::string text =
      fmt::format("{} predicted for {} rows: {}\n", quantityName(p.name, p.unit), p.predicted.size(), file);
  if (const auto rms = rmsError(p)) text += fmt::format("RMS error against the log: {:.4g} {}\n", *rms, p.unit);
  if (p.refused > 0) text += fmt::format("{} rows left out or outside the model's range\n", p.refused);
  return text;
}

}  // namespace simgap
