#include "friction_tables.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/core/statistics.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr std::size_t kCells = 24;  // of the maps, per axis
constexpr std::size_t kShown = 1500;
constexpr std::size_t kShownPerBand = 500;

/// Load of every row as the model sees it.
ArrayXd loadOf(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  std::vector<double> rig;
  for (const std::string& name : data.rig_names) rig.push_back(report.best().value(name));
  return data.totalLoad(rig);
}

ArrayXd measuredOf(const FrictionReport& report) {
  return report.options.predict_load ? report.data->load : report.data->effort;
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
    error.resize(report.laws.fits.size());
    tbb::parallel_for(std::size_t{0}, error.size(), [&](std::size_t f) {
      std::vector<double>& mean = error[f];
      mean.assign(count.size(), 0.0);
      for (const Block& rows : evenChunks(data.rows())) {
        const ArrayXd predicted = predictEffort(report.laws.fits[f], data, report.options, rows);
        for (std::size_t i = rows.begin; i < rows.end; ++i) {
          mean[cells[i]] += std::abs(predicted[static_cast<Index>(i - rows.begin)] - measured[static_cast<Index>(i)]);
        }
      }
      for (std::size_t c = 0; c < mean.size(); ++c) mean[c] = count[c] > 0.0 ? mean[c] / count[c] : std::nan("");
    });
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

/// Velocities at which a curve is drawn, denser where it bends. Slower than nearly all rows a law is a guess: a peak at
/// rest that no row has seen would only flatten the picture of what they have.
std::vector<double> curveVelocities(const FrictionData& data) {
  constexpr int kPoints = 120;
  constexpr double kSlowest = 0.01;  // share of the rows
  std::vector<double> speeds(static_cast<std::size_t>(data.velocity.size()));
  ArrayXd::Map(speeds.data(), data.velocity.size()) = data.velocity.abs();
  const double least = std::max(quantile(speeds, kSlowest), 1e-9), top = std::max(std::ranges::max(speeds), least);
  std::vector<double> velocities;
  for (int i = kPoints; i >= 0; --i) velocities.push_back(-(least + (top - least) * std::pow(1.0 * i / kPoints, 2)));
  for (int i = 0; i <= kPoints; ++i) velocities.push_back(-velocities[static_cast<std::size_t>(kPoints - i)]);
  return velocities;
}

/// Rows of a band, as many as a chart shows.
std::vector<Index> rowsOfBand(const ArrayXd& load, double low, double high) {
  std::vector<Index> rows, shown;
  for (Index i = 0; i < load.size(); ++i) {
    if (load[i] >= low && load[i] <= high) rows.push_back(i);
  }
  const std::size_t stride = 1 + rows.size() / kShownPerBand;
  for (std::size_t k = 0; k < rows.size(); k += stride) shown.push_back(rows[k]);
  return shown;
}

/// The largest velocity (at the joint) and load in the data.
struct WorkingPoint {
  double velocity, load;
};
WorkingPoint furthestPoint(const FrictionReport& report) {
  return {report.data->velocity.abs().maxCoeff() / report.ratio.value_or(1.0), loadOf(report).abs().maxCoeff()};
}

bool covers(const FrictionReport& report, const Requirement& requirement) {
  const WorkingPoint reached = furthestPoint(report);
  return reached.velocity >= requirement.velocity && reached.load >= requirement.torque;
}

}  // namespace

std::vector<TimeSample> timeSamples(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const ArrayXd measured = measuredOf(report);
  const std::size_t count = std::min(kShown, data.rows());
  const std::size_t begin = (data.rows() - count) / 2;
  std::vector<TimeSample> samples;
  for (std::size_t i = begin; i < begin + count; ++i) samples.push_back({i, measured[static_cast<Index>(i)], {}});
  for (const FrictionFit& fit : report.laws.fits) {
    const ArrayXd predicted = predictEffort(fit, data, report.options, {begin, begin + count});
    for (std::size_t k = 0; k < count; ++k) samples[k].predicted.push_back(predicted[static_cast<Index>(k)]);
  }
  return samples;
}

std::string mapsCsv(const FrictionReport& report) {
  const Grid grid(report);
  std::vector<std::string> header{quantityName("velocity", report.data->velocity_unit),
                                  quantityName("load", report.data->load_unit), "rows"};
  for (const FrictionFit& fit : report.laws.fits) header.push_back(fmt::format("mean_abs_error_{}", fit.law->name));
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
  const WorkingPoint reached = furthestPoint(report);
  std::vector<std::string> sentences;
  for (const Requirement& r : report.requirements) {
    sentences.push_back(fmt::format("{}: {:.3g} {} and {:.3g} {} {} (measured up to {:.3g} and {:.3g})", r.name,
                                    r.velocity, data.velocity_unit, r.torque, data.load_unit,
                                    covers(report, r) ? "are covered" : "are NOT covered", reached.velocity,
                                    reached.load));
  }
  return sentences;
}

std::string curvesCsv(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const ArrayXd load = loadOf(report);
  const FrictionFit& best = report.best();
  const DriveFeedForward scale = feedForward(*best.law, best.uncertainty.estimates);
  const auto friction = [&](double effort, double at) { return scale.k_a * (effort - scale.offset) - at; };
  CsvWriter csv(
      {"band", "series", quantityName("velocity", data.velocity_unit), quantityName("friction", data.load_unit)});
  for (const auto& [low, high] : loadBands(load)) {
    const std::string band = fmt::format("{:.3g} … {:.3g} {}", low, high, data.load_unit);
    for (const Index i : rowsOfBand(load, low, high)) {
      csv.add(band).add("measured").add(data.velocity[i]).add(friction(data.effort[i], load[i])).endRow();
    }
    for (const FrictionFit& fit : report.laws.fits) {
      const DriveFeedForward drive = feedForward(*fit.law, fit.uncertainty.estimates);
      const double middle = 0.5 * (low + high);
      for (const double w : curveVelocities(data)) {
        const double effort = drive.effort(middle, w, w < 0.0 ? -1.0 : 1.0);
        csv.add(band).add(fit.law->name).add(w).add(friction(effort, middle)).endRow();
      }
    }
  }
  return csv.text();
}

std::string frictionCsv(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const FrictionFit& best = report.best();
  const DriveFeedForward drive = feedForward(*best.law, best.uncertainty.estimates);
  CsvWriter csv({quantityName("load", data.load_unit), quantityName("velocity", data.velocity_unit),
                 quantityName("friction", data.load_unit)});
  for (const auto& [low, high] : loadBands(loadOf(report))) {
    const double load = 0.5 * (low + high);
    for (const double w : curveVelocities(data)) {
      csv.add(load).add(w).add(drive.friction.torque(w, w < 0.0 ? -1.0 : 1.0, load)).endRow();
    }
  }
  return csv.text();
}

std::string modelsCsv(const FrictionReport& report) {
  CsvWriter csv({"model", "name", "unit", "value", "sd"});
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); };
  for (const FrictionFit& fit : report.laws.fits) {
    for (const Estimate& e : fit.uncertainty.estimates) {
      csv.add(fit.law->name).add(e.name).add(e.unit).add(number(e.value)).add(number(e.sd)).endRow();
    }
  }
  return csv.text();
}

std::string requirementsCsv(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const double ratio = report.ratio.value_or(1.0);
  CsvWriter csv(
      {"name", quantityName("velocity", data.velocity_unit), quantityName("load", data.load_unit), "covered"});
  for (const Requirement& r : report.requirements) {
    csv.add(r.name).add(r.velocity * ratio).add(r.torque).add(covers(report, r) ? "true" : "false").endRow();
  }
  return csv.text();
}

}  // namespace simgap
