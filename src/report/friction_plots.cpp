#include "friction_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/core/units.h"
#include "simgap/report/charts.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr std::size_t kCells = 24;  // of the maps, per axis
constexpr std::size_t kShown = 1500;

/// Load of every row as the model sees it.
ArrayXd loadOf(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  ArrayXd load = data.load;
  for (Index k = 0; k < data.load_per.cols(); ++k) {
    load += report.fits[report.best].value(data.rig_names[static_cast<std::size_t>(k)]) * data.load_per.col(k);
  }
  return load;
}

ArrayXd measuredOf(const FrictionReport& report) {
  return report.options.predict_load ? report.data->load : report.data->effort;
}

std::string targetTitle(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  return report.options.predict_load ? fmt::format("load [{}]", data.load_unit)
                                     : fmt::format("{} [{}]", data.effort_name, data.effort_unit);
}

/// Sums over a grid of load and velocity.
struct Grid {
  std::vector<double> velocity, load;      ///< centres, shape (kCells)
  std::vector<double> count;               ///< shape (kCells^2), velocity runs fastest
  std::vector<std::vector<double>> error;  ///< shape (fits, kCells^2): mean absolute error; NaN without rows

  explicit Grid(const FrictionReport& report) {
    const FrictionData& data = *report.data;
    const ArrayXd loads = loadOf(report), measured = measuredOf(report);
    const double v = std::max(data.velocity.abs().maxCoeff(), 1e-12), l = std::max(loads.abs().maxCoeff(), 1e-12);
    for (std::size_t c = 0; c < kCells; ++c) {
      const double t = (2.0 * static_cast<double>(c) + 1.0) / static_cast<double>(kCells) - 1.0;
      velocity.push_back(v * t);
      load.push_back(l * t);
    }
    const auto cell = [](double value, double top) {
      const double place = (value / top + 1.0) / 2.0 * static_cast<double>(kCells);
      return std::min(static_cast<std::size_t>(std::max(place, 0.0)), kCells - 1);
    };
    std::vector<std::size_t> cells(data.rows());
    count.assign(kCells * kCells, 0.0);
    for (std::size_t i = 0; i < data.rows(); ++i) {
      const auto k = static_cast<Index>(i);
      cells[i] = cell(data.velocity[k], v) + kCells * cell(loads[k], l);
      count[cells[i]] += 1.0;
    }
    for (const FrictionFit& fit : report.fits) {
      const ArrayXd wrong = (predictEffort(fit, data, report.options) - measured).abs();
      std::vector<double> mean(count.size(), 0.0);
      for (std::size_t i = 0; i < data.rows(); ++i) mean[cells[i]] += wrong[static_cast<Index>(i)];
      for (std::size_t c = 0; c < mean.size(); ++c) mean[c] = count[c] > 0.0 ? mean[c] / count[c] : std::nan("");
      error.push_back(mean);
    }
  }

  std::vector<double> difference(std::size_t from, std::size_t to) const {
    std::vector<double> values(count.size());
    for (std::size_t c = 0; c < values.size(); ++c) values[c] = error[from][c] - error[to][c];
    return values;
  }
};

/// Quantile bands of the load, at most four.
std::vector<std::pair<double, double>> loadBands(const ArrayXd& load) {
  std::vector<double> sorted(load.begin(), load.end());
  std::ranges::sort(sorted);
  const auto quantile = [&](double q) {
    return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
  };
  if (sorted.front() == sorted.back()) return {{sorted.front(), sorted.back()}};
  std::vector<std::pair<double, double>> bands;
  for (const double q : {0.05, 0.35, 0.65, 0.95}) {
    const double width = 0.04 * (sorted.back() - sorted.front());
    bands.emplace_back(quantile(q) - width, quantile(q) + width);
  }
  return bands;
}

/// The effort a law predicts over velocity at one load; the friction alone when `friction_only`.
Curve lawCurve(const FrictionFit& fit, double load, double top, bool friction_only) {
  const DriveFeedForward drive = feedForward(*fit.law, fit.uncertainty.estimates);
  Curve curve{fmt::format("{} at {:.3g}", fit.law->name, load), {}, {}, false};
  for (int i = -120; i <= 120; ++i) {
    // Denser about rest, where friction bends; the sign changes between two points.
    const double t = i == 0 ? 1e-9 : static_cast<double>(i) / 120.0;
    const double w = top * t * std::abs(t), direction = w < 0.0 ? -1.0 : 1.0;
    curve.x.push_back(w);
    curve.y.push_back(friction_only ? drive.friction.torque(w, direction, load) : drive.effort(load, w, direction));
  }
  return curve;
}

void addCurves(const FrictionReport& report, Page& page) {
  const FrictionData& data = *report.data;
  const ArrayXd load = loadOf(report);
  const double top = data.velocity.abs().maxCoeff();
  const std::string velocity = fmt::format("velocity [{}]", data.velocity_unit);
  std::vector<Curve> friction;
  for (const auto& [low, high] : loadBands(load)) {
    const double middle = 0.5 * (low + high);
    friction.push_back(lawCurve(report.fits[report.best], middle, top, true));
    if (report.options.predict_load) continue;
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < data.rows(); ++i) {
      if (load[static_cast<Index>(i)] >= low && load[static_cast<Index>(i)] <= high) rows.push_back(i);
    }
    Curve measured{"measured", {}, {}, true};
    const std::size_t stride = std::max<std::size_t>(1, rows.size() / kShown);
    for (std::size_t k = 0; k < rows.size(); k += stride) {
      measured.x.push_back(data.velocity[static_cast<Index>(rows[k])]);
      measured.y.push_back(data.effort[static_cast<Index>(rows[k])]);
    }
    std::vector<Curve> curves{measured};
    for (const FrictionFit& fit : report.fits) curves.push_back(lawCurve(fit, middle, top, false));
    page.charts.push_back({fmt::format("Effort over velocity, load {:.3g} … {:.3g} {}", low, high, data.load_unit),
                           curveChart(curves, velocity, targetTitle(report))});
  }
  page.charts.push_back({fmt::format("Friction of {} at four loads", report.fits[report.best].law->name),
                         curveChart(friction, velocity, fmt::format("friction [{}]", data.load_unit))});
}

void addMaps(const FrictionReport& report, const Grid& grid, Page& page) {
  const FrictionData& data = *report.data;
  const std::string velocity = fmt::format("velocity [{}]", data.velocity_unit);
  const std::string load = fmt::format("load [{}]", data.load_unit);
  const std::string unit = report.options.predict_load ? data.load_unit : data.effort_unit;
  Map coverage{grid.velocity, grid.load, grid.count, false, true, "rows", {}};
  for (double& value : coverage.value) value = value > 0.0 ? value : std::nan("");
  for (const Requirement& r : report.requirements) {
    const double v = r.velocity * report.ratio.value_or(1.0);
    coverage.outline.name = "required";
    for (const auto& [x, y] :
         {std::pair{-v, -r.torque}, {v, -r.torque}, {v, r.torque}, {-v, r.torque}, {-v, -r.torque}}) {
      coverage.outline.x.push_back(x);
      coverage.outline.y.push_back(y);
    }
  }
  page.charts.push_back({"Where the data are: rows per cell", mapChart(coverage, velocity, load)});
  page.charts.push_back({fmt::format("Mean absolute error of {}", report.fits[0].law->name),
                         mapChart({grid.velocity, grid.load, grid.error[0], false, false, unit, {}}, velocity, load)});
  for (std::size_t f = 1; f < report.fits.size(); ++f) {
    page.charts.push_back(
        {fmt::format("Improvement of {} over {} (blue is better)", report.fits[f].law->name, report.fits[0].law->name),
         mapChart({grid.velocity, grid.load, grid.difference(0, f), true, false, unit, {}}, velocity, load)});
  }
}

void addProfile(const FrictionFit& fit, const FrictionData& data, Page& page) {
  if (fit.profile.axes.size() != 2 || fit.profile.axes[0].size() < 2 || fit.profile.axes[1].size() < 2) return;
  Map map;
  for (const double v : fit.profile.axes[0]) map.x.push_back(std::log10(v));
  for (const double d : fit.profile.axes[1]) map.y.push_back(std::log10(d));
  map.value.resize(fit.profile.cost.size());
  const double lowest = *std::ranges::min_element(fit.profile.cost);
  for (std::size_t i = 0; i < fit.profile.cost.size(); ++i) {
    const std::size_t columns = map.y.size();
    map.value[i / columns + map.x.size() * (i % columns)] = 1e-3 + 100.0 * (fit.profile.cost[i] / lowest - 1.0);
  }
  map.logarithmic = true;
  map.unit = "% above the lowest";
  page.charts.push_back({fmt::format("Cost of {} over the Stribeck velocity and exponent", fit.law->name),
                         mapChart(map, fmt::format("log10 v_s [{}]", data.velocity_unit), "log10 delta")});
}

void addParameterComparison(const FrictionReport& report, Page& page) {
  if (report.fits.size() < 2) return;
  std::vector<std::string> names;
  for (const FrictionFit& fit : report.fits) {
    for (const Estimate& e : fit.uncertainty.estimates) {
      if (std::ranges::find(names, e.name) == names.end()) names.push_back(e.name);
    }
  }
  PageTable table{"Parameters of all models, ± standard deviation", {"parameter"}, {}, false};
  std::vector<Series> series;
  for (const FrictionFit& fit : report.fits) {
    table.header.emplace_back(fit.law->name);
    series.push_back({std::string(fit.law->name), {}});
  }
  for (const std::string& name : names) {
    std::vector<std::string> row{name};
    double largest = 0.0;
    for (const FrictionFit& fit : report.fits) largest = std::max(largest, std::abs(fit.value(name)));
    for (std::size_t f = 0; f < report.fits.size(); ++f) {
      const auto& estimates = report.fits[f].uncertainty.estimates;
      const auto found = std::ranges::find(estimates, name, &Estimate::name);
      row.push_back(found == estimates.end() ? ""
                    : std::isfinite(found->sd) && found->sd > 0.0
                        ? fmt::format("{} ± {:.2g}", valueText(found->value, found->sd), found->sd)
                        : fmt::format("{:.5g}", found->value));
      series[f].y.push_back(found == estimates.end() || largest == 0.0 ? std::nan("") : found->value / largest);
    }
    table.rows.push_back(row);
  }
  page.tables.push_back(table);
  page.charts.push_back(
      {"Parameters of all models, relative to the largest", barChart(names, series, "relative value")});
}

}  // namespace

std::vector<TimeSample> timeSamples(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const ArrayXd measured = measuredOf(report);
  const std::size_t count = std::min(kShown, data.rows());
  const std::size_t begin = (data.rows() - count) / 2;
  std::vector<TimeSample> samples;
  for (std::size_t i = begin; i < begin + count; ++i) samples.push_back({i, measured[static_cast<Index>(i)], {}});
  std::vector<bool> shown(data.rows(), false);
  std::fill_n(shown.begin() + static_cast<std::ptrdiff_t>(begin), count, true);
  const FrictionData part = selectRows(data, shown);
  for (const FrictionFit& fit : report.fits) {
    const ArrayXd predicted = predictEffort(fit, part, report.options);
    for (std::size_t k = 0; k < count; ++k) samples[k].predicted.push_back(predicted[static_cast<Index>(k)]);
  }
  return samples;
}

std::string mapsCsv(const FrictionReport& report) {
  const Grid grid(report);
  std::vector<std::string> header{quantityName("velocity", report.data->velocity_unit),
                                  quantityName("load", report.data->load_unit), "rows"};
  for (const FrictionFit& fit : report.fits) header.push_back(fmt::format("mean_abs_error_{}", fit.law->name));
  CsvWriter csv(header);
  for (std::size_t c = 0; c < grid.count.size(); ++c) {
    if (grid.count[c] == 0.0) continue;
    csv.add(grid.velocity[c % kCells]).add(grid.load[c / kCells]).add(grid.count[c]);
    for (const auto& error : grid.error) csv.add(error[c]);
    csv.endRow();
  }
  return csv.text();
}

std::vector<std::string> requirementSentences(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const ArrayXd load = loadOf(report);
  const double velocity = data.velocity.abs().maxCoeff() / report.ratio.value_or(1.0), torque = load.abs().maxCoeff();
  std::vector<std::string> sentences;
  for (const Requirement& r : report.requirements) {
    const bool reached = velocity >= r.velocity && torque >= r.torque;
    sentences.push_back(fmt::format("{}: {:.3g} {} and {:.3g} {} {} (measured up to {:.3g} and {:.3g})", r.name,
                                    r.velocity, data.velocity_unit, r.torque, data.load_unit,
                                    reached ? "are covered" : "are NOT covered", velocity, torque));
  }
  return sentences;
}

void addFrictionCharts(const FrictionReport& report, Page& page) {
  const FrictionData& data = *report.data;
  Curve measured{"measured", {}, {}, false};
  std::vector<Curve> curves;
  for (const FrictionFit& fit : report.fits) curves.push_back({std::string(fit.law->name), {}, {}, false});
  for (const TimeSample& sample : timeSamples(report)) {
    const double t = data.time[static_cast<Index>(sample.index)];
    measured.x.push_back(t);
    measured.y.push_back(sample.measured);
    for (std::size_t f = 0; f < curves.size(); ++f) {
      curves[f].x.push_back(t);
      curves[f].y.push_back(sample.predicted[f]);
    }
  }
  curves.insert(curves.begin(), measured);
  page.charts.push_back({"Measured and predicted over time", curveChart(curves, "time [s]", targetTitle(report))});
  addCurves(report, page);
  addMaps(report, Grid(report), page);
  addProfile(report.fits[report.best], data, page);
  addParameterComparison(report, page);
}

}  // namespace simgap
