#include "simgap/fit/actuators/friction_maps.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr std::size_t kCells = 24;  // of the map, per axis
constexpr std::size_t kShown = 1200;

}  // namespace

ArrayXd FittedRows::load() const {
  std::vector<double> rig;
  for (const std::string& name : data.rig_names) rig.push_back(best().value(name));
  return data.totalLoad(rig);
}

ErrorMap errorMap(const FittedRows& rows) {
  const FrictionData& data = rows.data;
  const ArrayXd loads = rows.load(), &measured = rows.measured();
  ErrorMap map;
  const double v = std::max(data.velocity.abs().maxCoeff(), 1e-12), l = std::max(loads.abs().maxCoeff(), 1e-12);
  for (std::size_t c = 0; c < kCells; ++c) {
    const double t = (2.0 * static_cast<double>(c) + 1.0) / static_cast<double>(kCells) - 1.0;
    map.velocity.push_back(v * t);
    map.load.push_back(l * t);
  }
  const auto cell = [](double value, double top) {
    const double place = (value / top + 1.0) / 2.0 * static_cast<double>(kCells);
    return std::min(static_cast<std::size_t>(std::max(place, 0.0)), kCells - 1);
  };
  std::vector<std::size_t> cells(data.rows());
  map.count.assign(kCells * kCells, 0.0);
  for (std::size_t i = 0; i < data.rows(); ++i) {
    const auto k = static_cast<Index>(i);
    cells[i] = cell(data.velocity[k], v) + kCells * cell(loads[k], l);
    map.count[cells[i]] += 1.0;
  }
  map.error.resize(rows.laws.fits.size());
  tbb::parallel_for(std::size_t{0}, map.error.size(), [&](std::size_t f) {
    std::vector<double>& mean = map.error[f];
    mean.assign(map.count.size(), 0.0);
    const FrictionFit& fit = rows.laws.fits[f];
    const LeastSquaresProblem problem = makeFrictionProblem(*fit.law, data, rows.options);
    for (const Block& chunk : evenChunks(data.rows())) {
      const ArrayXd predicted = predictEffort(problem, fit, data, rows.options, chunk);
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        mean[cells[i]] += std::abs(predicted[i - chunk.begin] - measured[i]);
      }
    }
    for (std::size_t c = 0; c < mean.size(); ++c) mean[c] = map.count[c] > 0.0 ? mean[c] / map.count[c] : std::nan("");
  });
  return map;
}

std::vector<TimeSample> timeSamples(const FittedRows& rows) {
  const FrictionData& data = rows.data;
  const ArrayXd& measured = rows.measured();
  const std::size_t count = std::min(kShown, data.rows());
  const std::size_t begin = (data.rows() - count) / 2;
  std::vector<TimeSample> samples;
  for (std::size_t i = begin; i < begin + count; ++i) samples.push_back({i, measured[i], {}});
  for (const FrictionFit& fit : rows.laws.fits) {
    const ArrayXd predicted = predictEffort(fit, data, rows.options, {begin, begin + count});
    for (std::size_t k = 0; k < count; ++k) samples[k].predicted.push_back(predicted[k]);
  }
  return samples;
}

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

std::vector<double> curveVelocities(const FrictionData& data) {
  constexpr int kPoints = 120;
  constexpr double kSlowest = 0.01;  // share of the rows
  std::vector<double> speeds(static_cast<std::size_t>(data.velocity.size()));
  ArrayXd::Map(speeds.data(), data.velocity.size()) = data.velocity.abs();
  const double least = std::max(quantile(speeds, kSlowest), 1e-9), top = std::max(std::ranges::max(speeds), least);
  std::vector<double> velocities;
  for (int i = kPoints; i >= 0; --i) velocities.push_back(-(least + (top - least) * std::pow(1.0 * i / kPoints, 2)));
  for (int i = 0; i <= kPoints; ++i) velocities.push_back(-velocities[kPoints - i]);
  return velocities;
}

}  // namespace simgap
