/// \file
/// Chart.js configurations besides those of page.h: points and curves over x, maps of a value over two axes.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"

namespace simgap {

struct Curve {
  std::string name;
  std::vector<double> x, y;
  bool points = false;  ///< dots instead of a line
};

/// Curves over a linear x axis. Colours go in turn; a curve whose name begins like the one before it keeps its colour.
Json curveChart(const std::vector<Curve>& curves, const std::string& x_title, const std::string& y_title);

/// A value per cell of a grid; NaN cells stay empty.
struct Map {
  std::vector<double> x, y;   ///< centres of the cells, shape (X), (Y)
  std::vector<double> value;  ///< shape (X Y), x runs fastest
  bool diverging = false;     ///< two colours about 0 instead of one scale
  bool logarithmic = false;   ///< of the value's colour
  std::string unit;
  Curve outline = {};  ///< drawn on top, when it has points
};
Json mapChart(const Map& map, const std::string& x_title, const std::string& y_title);

}  // namespace simgap
