#include "simgap/report/html/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace simgap {
namespace {

/// Five digits are finer than any screen; all 17 of a double would triple the page.
constexpr int kDigits = 5;
/// An axis may lie far from 0: seconds of an hour.
constexpr int kAxisDigits = 7;

Json shortNumber(double value, int digits = kDigits) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.{}g}", value, digits).c_str(), nullptr);
}

Json shortNumbers(const std::vector<double>& values, int digits = kDigits) {
  Json numbers = Json::array();
  for (const double value : values) numbers.push_back(shortNumber(value, digits));
  return numbers;
}

Json axisJson(const Axis& axis) { return {{"title", axis.title}, {"log", axis.logarithmic}}; }

/// Of Series::Style, in its order, as report.js knows them.
constexpr const char* kStyles[] = {"line", "dashed", "points"};

/// Lines that share their x hold it once: the others name the line that has it.
Json seriesJson(const std::vector<Series>& all) {
  Json list = Json::array();
  std::vector<std::vector<double>> held;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Series series = all[i].x.empty() || !all[i].half.empty() ? all[i] : thinned(all[i]);
    const int colour = series.colour >= 0 ? series.colour : static_cast<int>(i);
    const auto same = std::ranges::find(held, series.x);
    list.push_back({{"name", series.name},
                    {"x", same == held.end() ? shortNumbers(series.x, kAxisDigits) : Json(same - held.begin())},
                    {"y", shortNumbers(series.y)},
                    {"style", kStyles[static_cast<int>(series.style)]},
                    {"colour", colour},
                    {"faint", series.faint}});
    if (!series.half.empty()) list.back()["half"] = shortNumbers(series.half);
    held.push_back(series.x);
  }
  return list;
}

}  // namespace

Series thinned(const Series& line, std::size_t most) {
  const std::size_t count = line.y.size();
  if (count <= most) return line;
  Series result = line;
  result.x.clear();
  result.y.clear();
  const auto keep = [&](std::size_t i) {
    result.x.push_back(line.x[i]);
    result.y.push_back(line.y[i]);
  };
  const std::size_t stretches = std::max<std::size_t>(1, most / 2);
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * count / stretches, end = (s + 1) * count / stretches;
    std::size_t low = end, high = end, gap = end;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(line.y[i])) {
        gap = i;
        continue;
      }
      if (low == end || line.y[i] < line.y[low]) low = i;
      if (high == end || line.y[i] > line.y[high]) high = i;
    }
    std::vector<std::size_t> kept{low, high, gap};
    std::ranges::sort(kept);
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    for (const std::size_t i : kept) {
      if (i < end) keep(i);
    }
  }
  return result;
}

Chart lineChart(std::string caption, const Axis& x, const Axis& y, const std::vector<Series>& series) {
  return {std::move(caption),
          "",
          {{"kind", "lines"}, {"x", axisJson(x)}, {"y", axisJson(y)}, {"series", seriesJson(series)}}};
}

void makeZoomable(Chart& chart, const std::string& group) { chart.spec["zoom"] = group; }

Chart barChart(std::string caption, const std::vector<std::string>& labels, const Axis& y,
               const std::vector<Series>& series) {
  return {std::move(caption),
          "",
          {{"kind", "bars"}, {"labels", labels}, {"y", axisJson(y)}, {"series", seriesJson(series)}}};
}

Chart intervalChart(std::string caption, const Axis& x, const std::vector<IntervalRow>& rows) {
  Json list = Json::array();
  for (const IntervalRow& row : rows) {
    list.push_back({{"name", row.name},
                    {"value", shortNumber(row.value)},
                    {"lower", shortNumber(row.lower)},
                    {"upper", shortNumber(row.upper)},
                    {"group", row.group},
                    {"colour", row.colour},
                    {"marked", row.marked}});
  }
  return {std::move(caption), "", {{"kind", "intervals"}, {"x", axisJson(x)}, {"rows", list}}};
}

Chart mapChart(std::string caption, const Axis& x, const Axis& y, const Map& map) {
  return {std::move(caption),
          "",
          {{"kind", "map"},
           {"x", axisJson(x)},
           {"y", axisJson(y)},
           {"columns", shortNumbers(map.x, kAxisDigits)},
           {"rows", shortNumbers(map.y, kAxisDigits)},
           {"column_names", map.x_names},
           {"row_names", map.y_names},
           {"value", shortNumbers(map.value)},
           {"unit", map.unit},
           {"diverging", map.diverging},
           {"log", map.logarithmic},
           {"range", map.range},
           {"written", map.written},
           {"series", seriesJson(map.outlines)}}};
}

}  // namespace simgap
