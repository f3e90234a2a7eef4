#include "simgap/fit/actuators/requirements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/rotation.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

using Eigen::Index;

constexpr std::size_t kCellsPerAxis = 10, kFewestRowsInCell = 10;

/// Of equal bins between two ends; none outside.
std::optional<std::size_t> binOf(double value, double lower, double upper, std::size_t bins) {
  if (!(value >= lower && value <= upper)) return std::nullopt;
  const double place = (value - lower) / std::max(upper - lower, 1e-300) * static_cast<double>(bins);
  return std::min(static_cast<std::size_t>(place), bins - 1);
}

/// Share of the bins with enough rows.
double filled(const std::vector<std::size_t>& rows) {
  const auto enough = std::ranges::count_if(rows, [](std::size_t n) { return n >= kFewestRowsInCell; });
  return static_cast<double>(enough) / static_cast<double>(rows.size());
}

}  // namespace

std::vector<Requirement> paperRequirements() {
  return {{"shoulder flexion/extension", 71.0 * kDegree, 20.0, std::pair(-135.0 * kDegree, 100.0 * kDegree)},
          {"elbow flexion/extension", 91.0 * kDegree, 20.0, std::pair(0.0, 135.0 * kDegree)}};
}

std::vector<Requirement> readRequirements(const std::vector<std::string>& texts) {
  std::vector<Requirement> all;
  for (const std::string& text : texts) {
    if (text == "paper") {
      for (const Requirement& r : paperRequirements()) all.push_back(r);
      continue;
    }
    const std::size_t first = text.find(':'), last = text.rfind(':');
    // 0 where there is no number, which no working point has.
    const auto number = [&](std::size_t begin, std::size_t end) {
      return first < last ? parseNumber(text.substr(begin, end - begin)).value_or(0.0) : 0.0;
    };
    const double velocity = number(first + 1, last), torque = number(last + 1, text.size());
    if (first == 0 || !(velocity > 0.0 && torque > 0.0)) {
      throw ConfigError(
          fmt::format("--require: found '{}', expected NAME:DEG_PER_S:NM with numbers above 0, or paper", text));
    }
    all.push_back({text.substr(0, first), unitConversion("deg_s", "rad_s")->operator()(velocity), torque});
  }
  return all;
}

CoveredRange coveredRange(const Requirement& requirement, const Eigen::ArrayXd& velocity, const Eigen::ArrayXd& load,
                          const Eigen::ArrayXd& position, double ratio) {
  CoveredRange covered{velocity.abs().maxCoeff() / ratio, load.abs().maxCoeff()};
  const double v = requirement.velocity * ratio, tau = requirement.torque;
  std::vector<std::size_t> cells(kCellsPerAxis * kCellsPerAxis);
  for (Index i = 0; i < velocity.size(); ++i) {
    const auto column = binOf(velocity[i], -v, v, kCellsPerAxis), row = binOf(load[i], -tau, tau, kCellsPerAxis);
    if (column && row) ++cells[*column + kCellsPerAxis * *row];
  }
  covered.cells = filled(cells);
  if (requirement.angle && position.size() > 0) {
    std::vector<std::size_t> angles(kCellsPerAxis);
    for (Index i = 0; i < position.size(); ++i) {
      const auto bin = binOf(position[i] / ratio, requirement.angle->first, requirement.angle->second, kCellsPerAxis);
      if (bin) ++angles[*bin];
    }
    covered.angle = filled(angles);
  }
  return covered;
}

Histogram histogramOf(const Eigen::ArrayXd& values, std::size_t bins) {
  const double lower = values.minCoeff(), upper = values.maxCoeff();
  Histogram histogram{{}, std::vector<std::size_t>(bins)};
  for (std::size_t b = 0; b <= bins; ++b) {
    histogram.edges.push_back(std::lerp(lower, upper, static_cast<double>(b) / static_cast<double>(bins)));
  }
  for (Index i = 0; i < values.size(); ++i) ++histogram.rows[*binOf(values[i], lower, upper, bins)];
  return histogram;
}

}  // namespace simgap
