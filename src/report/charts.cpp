#include "simgap/report/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace simgap {
namespace {

constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9"};

Json points(const Curve& curve) {
  Json data = Json::array();
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (std::isfinite(curve.x[i]) && std::isfinite(curve.y[i])) data.push_back({{"x", curve.x[i]}, {"y", curve.y[i]}});
  }
  return data;
}

Json dataset(const Curve& curve, const char* colour) {
  return {{"label", curve.name},   {"data", points(curve)},
          {"borderColor", colour}, {"backgroundColor", colour},
          {"borderWidth", 2},      {"showLine", !curve.points},
          {"fill", false},         {"pointRadius", curve.points ? 1.5 : 0.0},
          {"tension", 0}};
}

Json scatter(const std::string& x_title, const std::string& y_title) {
  return {{"type", "scatter"},
          {"data", {{"datasets", Json::array()}}},
          {"options",
           {{"scales",
             {{"x", {{"title", {{"display", true}, {"text", x_title}}}}},
              {"y", {{"title", {{"display", true}, {"text", y_title}}}}}}}}}};
}

using Colour = std::array<double, 3>;

std::string blend(const Colour& a, const Colour& b, double t) {
  const auto mix = [&](std::size_t k) { return static_cast<int>(std::lround(a[k] + t * (b[k] - a[k]))); };
  return fmt::format("rgb({},{},{})", mix(0), mix(1), mix(2));
}

/// t from 0 to 1: pale yellow over green to dark blue; diverging from -1 to 1: vermilion over white to blue.
std::string colourOf(double t, bool diverging) {
  constexpr Colour kPale{253, 231, 37}, kMiddle{33, 145, 140}, kDark{68, 1, 84};
  constexpr Colour kNegative{213, 94, 0}, kZero{245, 245, 245}, kPositive{0, 114, 178};
  if (diverging)
    return t < 0.0 ? blend(kZero, kNegative, std::min(-t, 1.0)) : blend(kZero, kPositive, std::min(t, 1.0));
  return t < 0.5 ? blend(kDark, kMiddle, 2.0 * t) : blend(kMiddle, kPale, 2.0 * t - 1.0);
}

}  // namespace

Json curveChart(const std::vector<Curve>& curves, const std::string& x_title, const std::string& y_title) {
  Json chart = scatter(x_title, y_title);
  std::size_t colour = 0;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    if (i > 0 && !curves[i].name.starts_with(curves[i - 1].name)) ++colour;
    chart["data"]["datasets"].push_back(dataset(curves[i], kColours[colour % std::size(kColours)]));
  }
  return chart;
}

Json mapChart(const Map& map, const std::string& x_title, const std::string& y_title) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const auto scaled = [&](double value) { return map.logarithmic ? std::log10(std::max(value, 1e-300)) : value; };
  for (const double value : map.value) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, scaled(value));
    high = std::max(high, scaled(value));
  }
  const double largest = std::max(std::abs(low), std::abs(high));
  Json data = Json::array(), colours = Json::array();
  for (std::size_t i = 0; i < map.value.size(); ++i) {
    if (!std::isfinite(map.value[i])) continue;
    const double t = map.diverging ? scaled(map.value[i]) / std::max(largest, 1e-300)
                                   : (scaled(map.value[i]) - low) / std::max(high - low, 1e-300);
    data.push_back({{"x", map.x[i % map.x.size()]}, {"y", map.y[i / map.x.size()]}});
    colours.push_back(colourOf(t, map.diverging));
  }
  const auto text = [&](double value) {
    return fmt::format("{:.3g}", map.logarithmic ? std::pow(10.0, value) : value);
  };
  const std::string legend = data.empty() ? "no data"
                             : map.diverging
                                 ? fmt::format("vermilion −{0} … white 0 … blue +{0} {1}", text(largest), map.unit)
                                 : fmt::format("dark {} … pale {} {}", text(low), text(high), map.unit);
  Json chart = scatter(x_title, y_title);
  const double width = 420.0 / static_cast<double>(std::max<std::size_t>(map.x.size(), 1));
  const double height = 130.0 / static_cast<double>(std::max<std::size_t>(map.y.size(), 1));
  if (!map.outline.x.empty()) chart["data"]["datasets"].push_back(dataset(map.outline, "#000000"));
  chart["data"]["datasets"].push_back({{"label", legend},
                                       {"data", data},
                                       {"pointBackgroundColor", colours},
                                       {"pointBorderColor", colours},
                                       {"backgroundColor", colourOf(1.0, map.diverging)},
                                       {"pointStyle", "rect"},
                                       {"pointRadius", std::max(2.0, std::min(width, height))},
                                       {"showLine", false}});
  return chart;
}

}  // namespace simgap
