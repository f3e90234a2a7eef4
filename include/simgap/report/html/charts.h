/// \file
/// What a chart of a page shows: numbers, names and units. How it looks (colours, dark and light, tooltips, the table
/// behind it) is decided in templates/report.js, which gives the description to Chart.js.
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"

namespace simgap {

struct Axis {
  std::string title;  ///< with its unit: "velocity [rad/s]"
  bool logarithmic = false;
};

/// One line, cloud of points or row of bars.
struct Series {
  enum class Style { kLine, kDashed, kPoints };
  std::string name;
  std::vector<double> x;  ///< empty for bars, which have one value per label
  std::vector<double> y;  ///< NaN leaves a gap
  Style style = Style::kLine;
  int colour = -1;                ///< place in the palette; -1: the series' own place in the chart
  bool faint = false;             ///< stands behind others, pale and broad: "before", "measured"
  std::vector<double> half = {};  ///< half width of an interval about y; empty: none
};

/// A value with its interval, as one row of a chart.
struct IntervalRow {
  std::string name;
  double value;
  double lower, upper;     ///< NaN: unknown
  std::string group = {};  ///< rows of a group have one colour and one entry in the legend
  int colour = 0;          ///< of the group: place in the palette, and in the legend
  bool marked = false;     ///< drawn as a triangle: at a bound
};

/// A value per cell of a grid; NaN cells stay empty.
struct Map {
  std::vector<double> x, y;                   ///< centres of the cells, shape (X), (Y)
  std::vector<double> value;                  ///< shape (X Y), x runs fastest
  std::string unit;                           ///< of the value
  bool diverging = false;                     ///< two colours about 0 instead of one scale
  bool logarithmic = false;                   ///< of the value's colour
  double range = 0.0;                         ///< of a diverging scale; 0: the largest value
  bool written = false;                       ///< the value stands in its cell
  std::vector<std::string> x_names, y_names;  ///< of the cells, instead of numbers
  std::vector<Series> outlines;               ///< lines on top
};

struct Chart {
  std::string caption;
  std::string note;  ///< how to read it; may be empty
  Json spec;
  bool wide = false;  ///< takes the page's whole width
};

/// Curves and points over x.
Chart lineChart(std::string caption, const Axis& x, const Axis& y, const std::vector<Series>& series);
/// Lets a reader zoom into a chart of lines; all of `group` show the same stretch.
void makeZoomable(Chart& chart, const std::string& group = "time");
/// Groups of bars, one per label.
Chart barChart(std::string caption, const std::vector<std::string>& labels, const Axis& y,
               const std::vector<Series>& series);
Chart intervalChart(std::string caption, const Axis& x, const std::vector<IntervalRow>& rows);
Chart mapChart(std::string caption, const Axis& x, const Axis& y, const Map& map);

/// The largest number of points of a line that a page holds.
inline constexpr std::size_t kMostPoints = 2000;

/// The same on a page with so many lines over time, which stays small enough to be sent around.
inline std::size_t pointsPerLine(std::size_t lines) {
  constexpr std::size_t kOfAPage = 10'000, kFewest = 300;
  return std::clamp(kOfAPage / std::max<std::size_t>(1, lines), kFewest, kMostPoints);
}

/// A line with at most about `most` points in which every peak survives: of each stretch the lowest and the highest
/// point stay, in order; a gap stays a gap.
Series thinned(const Series& line, std::size_t most = kMostPoints);

}  // namespace simgap
