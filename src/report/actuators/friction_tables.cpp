#include "friction_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/core/units.h"
#include "simgap/model/actuator/friction_drive.h"
#include "simgap/report/table.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr std::size_t kShownPerBand = 500;

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

/// Of the motor in the rows that were fitted; empty when the log has none.
ArrayXd positionOf(const FrictionReport& report) {
  if (report.position.empty()) return {};
  ArrayXd position(report.data->velocity.size());
  for (Index i = 0; i < position.size(); ++i) position[i] = report.position[report.data->row[i]];
  return position;
}

CoveredRange coveredBy(const FrictionReport& report, const Requirement& r) {
  return coveredRange(r, report.data->velocity, report.rows().load(), positionOf(report), report.ratio.value_or(1.0));
}

}  // namespace

std::string mapsCsv(const FrictionReport& report) {
  const ErrorMap grid = errorMap(report.rows());
  std::vector<std::string> header{quantityName("velocity", report.data->velocity_unit),
                                  quantityName("load", report.data->load_unit), "rows"};
  for (const FrictionFit& fit : report.laws.fits) header.push_back(fmt::format("mean_abs_error_{}", fit.law->name));
  CsvWriter csv(header);
  for (std::size_t c = 0; c < grid.count.size(); ++c) {
    if (grid.count[c] == 0.0) continue;
    csv.add(grid.velocity[c % grid.velocity.size()]).add(grid.load[c / grid.velocity.size()]).add(grid.count[c]);
    for (const auto& error : grid.error) csv.add(error[c]);
    csv.endRow();
  }
  return csv.text();
}

std::vector<std::pair<std::string, std::string>> requirementSentences(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  std::vector<std::pair<std::string, std::string>> sentences;
  for (const Requirement& r : report.requirements) {
    const CoveredRange covered = coveredBy(report, r);
    std::string text = fmt::format(
        "{:.3g} {} and {:.3g} {} {} (measured up to {:.3g} and {:.3g}); rows in {:.0f} % of that range", r.velocity,
        unitTitle(data.velocity_unit), r.torque, unitTitle(data.load_unit),
        covered.covers(r) ? "are covered" : "are NOT covered", covered.velocity, covered.load, 100.0 * covered.cells);
    if (covered.angle) text += fmt::format(", at {:.0f} % of its angles", 100.0 * *covered.angle);
    sentences.emplace_back("requirement, " + r.name, std::move(text));
  }
  return sentences;
}

std::string histogramsCsv(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const double ratio = report.ratio.value_or(1.0);
  CsvWriter csv({"quantity", "lower", "upper", "rows"});
  const auto add = [&](const std::string& quantity, const ArrayXd& values) {
    const Histogram histogram = histogramOf(values);
    for (std::size_t b = 0; b < histogram.rows.size(); ++b) {
      csv.add(quantity).add(histogram.edges[b]).add(histogram.edges[b + 1]);
      csv.add(static_cast<double>(histogram.rows[b])).endRow();
    }
  };
  add(quantityName("motor_velocity", data.velocity_unit), data.velocity);
  if (report.ratio) add(quantityName("joint_velocity", data.velocity_unit), data.velocity / ratio);
  add(quantityName("load", data.load_unit), report.rows().load());
  if (!report.position.empty()) {
    add(quantityName(report.ratio ? "joint_position" : "motor_position", data.angle_unit), positionOf(report) / ratio);
  }
  return csv.text();
}

std::string curvesCsv(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const ArrayXd load = report.rows().load();
  const FrictionFit& best = report.best();
  const DriveFeedForward scale = feedForward(*best.law, best.uncertainty.estimates);
  const auto friction = [&](double effort, double at) { return scale.k_a * (effort - scale.offset) - at; };
  CsvWriter csv(
      {"band", "series", quantityName("velocity", data.velocity_unit), quantityName("friction", data.load_unit)});
  for (const auto& [low, high] : loadBands(load)) {
    const std::string band = fmt::format("{:.3g} … {:.3g} {}", low, high, unitTitle(data.load_unit));
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
  for (const auto& [low, high] : loadBands(report.rows().load())) {
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
  CsvWriter csv({"name", quantityName("velocity", data.velocity_unit), quantityName("load", data.load_unit), "covered",
                 "cells_covered", "angles_covered"});
  for (const Requirement& r : report.requirements) {
    const CoveredRange covered = coveredBy(report, r);
    csv.add(r.name).add(r.velocity * ratio).add(r.torque).add(covered.covers(r) ? "true" : "false");
    csv.add(covered.cells).add(covered.angle ? fmt::format("{}", *covered.angle) : "").endRow();
  }
  return csv.text();
}

}  // namespace simgap
