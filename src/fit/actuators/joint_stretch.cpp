#include "simgap/fit/actuators/joint_stretch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/actuator_model.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr int kStretchCells = 12;  // per axis

/// Offset and lag of the encoders that explain `rest` best, over the rows that count.
Eigen::Vector2d encodersOf(const ArrayXd& rest, const PreparedLog& log) {
  const Index n = std::ranges::count(log.data.keep, true);
  Eigen::MatrixXd a(n, 2), b(n, 1);
  Index row = 0;
  for (Index i = 0; i < rest.size(); ++i) {
    if (!log.data.keep[i]) continue;
    a.row(row) << 1.0, -log.data.rows.speed[i];
    b(row++, 0) = rest[i];
  }
  return solveLeastSquares(a, b);
}

double rmsOfKept(const ArrayXd& error, const PreparedLog& log) {
  double squares = 0.0, n = 0.0;
  for (Index i = 0; i < error.size(); ++i) {
    if (!log.data.keep[i]) continue;
    squares += error[i] * error[i];
    n += 1.0;
  }
  return std::sqrt(squares / n);
}

/// \param measured  stretch of every row
std::vector<StretchCell> cellsOf(const PreparedLog& log, const ArrayXd& measured, const JointStretch& model) {
  const ArrayXd &load = log.data.rows.load, &angle = log.data.rows.joint_angle;
  const auto placed = [](const ArrayXd& values, Index i) {
    const double low = values.minCoeff(), high = values.maxCoeff();
    return std::min(static_cast<int>((values[i] - low) / std::max(high - low, 1e-12) * kStretchCells),
                    kStretchCells - 1);
  };
  const auto middle = [](const ArrayXd& values, int cell) {
    return std::lerp(values.minCoeff(), values.maxCoeff(), (cell + 0.5) / kStretchCells);
  };
  std::map<std::pair<int, int>, StretchCell> cells;
  for (Index i = 0; i < load.size(); ++i) {
    if (!log.data.keep[i]) continue;
    const std::pair<int, int> place{placed(load, i), placed(angle, i)};
    StretchCell& cell =
        cells.try_emplace(place, StretchCell{middle(load, place.first), middle(angle, place.second), 0.0, 0.0, 0.0})
            .first->second;
    cell.rows += 1.0;
    cell.measured += (measured[i] - cell.measured) / cell.rows;
    cell.modelled += (model.stretch(load[i]) - cell.modelled) / cell.rows;
  }
  std::vector<StretchCell> list;
  for (const auto& [place, cell] : cells) list.push_back(cell);
  return list;
}

}  // namespace

double JointStretch::stretch(double load) const { return (compliance - hardening * std::abs(load)) * load; }

double JointStretch::stiffness(double load) const {
  const double slope = compliance - 2.0 * hardening * std::abs(load);
  return slope > 0.0 ? 1.0 / slope : INFINITY;
}

JointStretch predictJointAngle(const FittedModel& model, const CsvTable& table, const Bench& bench) {
  const std::string_view stretches = actuator_effects::ofTransmission().name;
  const auto own = std::ranges::find(model.extensions, stretches, &Extension::effect);
  if (own == model.extensions.end()) {
    throw ConfigError(
        fmt::format("found no {} in the model with --joint-angle, expected that of simgap diagnose on a log "
                    "with both angles",
                    stretches));
  }
  for (const Extension& other : subjectOf(model).of_angles) {
    if (other.effect == stretches) continue;
    throw ConfigError(
        fmt::format("found {} in the model with --joint-angle, expected {} alone", other.effect, stretches));
  }
  if (!bench.ratio) throw ConfigError("found no ratio with --joint-angle, expected --ratio, or one in the model");
  if (!table.offersQuantity("motor_position", "rad")) {
    throw DataError(table.name() + ":1: found no motor_position, expected it with --joint-angle");
  }
  const PreparedLog log = prepareLog(table, bench, subjectOf(model).base.kind);
  const ArrayXd& load = log.data.rows.load;
  const ArrayXd stiff = log.data.rows.motor_angle / *bench.ratio;
  JointStretch result;
  result.compliance = own->value("compliance");
  result.hardening = own->value("hardening");
  result.largest_load = load.abs().maxCoeff();
  ArrayXd angle = stiff;
  for (Index i = 0; i < angle.size(); ++i) angle[i] -= result.stretch(load[i]);
  const bool both = table.offersQuantity("joint_position", "rad");
  if (both) {
    const ArrayXd& joint = log.data.rows.joint_angle;
    const Eigen::Vector2d of_stiff = encodersOf(joint - stiff, log), encoders = encodersOf(joint - angle, log);
    result.stiff_rms = rmsOfKept(stiff + of_stiff[0] - of_stiff[1] * log.data.rows.speed - joint, log);
    result.offset = encoders[0];
    result.lag = encoders[1];
    angle += result.offset - result.lag * log.data.rows.speed;
    result.cells = cellsOf(log, stiff + result.offset - result.lag * log.data.rows.speed - joint, result);
  }
  result.angle = {"joint_position", "rad", {}, {}, {}, 0};
  for (Index i = 0; i < angle.size(); ++i) {
    if (!log.data.keep[i]) continue;
    result.angle.time.push_back(log.data.rows.time[i]);
    result.angle.predicted.push_back(angle[i]);
    if (both) result.angle.measured.push_back(log.data.rows.joint_angle[i]);
  }
  result.angle.refused = static_cast<std::size_t>(angle.size()) - result.angle.time.size();
  return result;
}

}  // namespace simgap
