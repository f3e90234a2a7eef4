#include "real/planting.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>
#include <unsupported/Eigen/FFT>
#include <utility>

#include "simgap/core/csv.h"

namespace simgap::test {
namespace {

using Series = Eigen::ArrayXd;
using Eigen::Index;

/// The measured motion, as far as a planted force depends on it.
struct Motion {
  Series time, angle, speed, acceleration, way, moving, effort;
  double top = 0.0;  ///< speed that 1 % of the rows exceed
  bool lifts = false;
};

double quantile(Series values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<Index>(share * static_cast<double>(values.size() - 1))];
}

/// Slope of a straight line through `reach` rows on either side (Savitzky & Golay 1964).
Series slope(const Series& time, const Series& values, Index reach) {
  Series result(values.size());
  for (Index i = 0; i < values.size(); ++i) {
    const Index first = std::max<Index>(0, i - reach), n = std::min(values.size() - 1, i + reach) - first + 1;
    const Series t = time.segment(first, n) - time.segment(first, n).mean();
    result[i] = (t * values.segment(first, n)).sum() / std::max(t.square().sum(), 1e-30);
  }
  return result;
}

Series series(const std::vector<double>& values) {
  return Eigen::Map<const Series>(values.data(), static_cast<Index>(values.size()));
}

Motion motionOf(const PlantingPlan& plan, LogTable log) {
  Motion m;
  m.lifts = realLog(plan.log).bench.find("pendulum") != std::string::npos;
  m.time = series(log.column("time_s"));
  m.effort = series(log.column(plan.effort));
  m.angle = series(log.column(plan.position));
  m.speed = plan.velocity.empty() ? slope(m.time, m.angle, 5) : series(log.column(plan.velocity));
  m.acceleration = slope(m.time, m.speed, 4);
  m.top = quantile(m.speed.abs(), 0.99);
  m.moving = (m.speed.abs() > 0.02 * m.top).cast<double>();
  m.way = Series::Zero(m.speed.size());
  double way = 0.0;
  for (Index i = 0; i < m.speed.size(); ++i) {
    if (m.moving[i] > 0.0) way = m.speed[i] > 0.0 ? 1.0 : -1.0;
    m.way[i] = way;
  }
  return m;
}

/// What laws take up: an offset, friction, viscous friction, inertia; and of one that lifts a weight its pull.
Eigen::MatrixXd ordinary(const Motion& m, bool lifts) {
  Eigen::MatrixXd x(m.effort.size(), lifts ? 6 : 4);
  x.leftCols(4) << Series::Ones(m.effort.size()), m.way * m.moving, m.speed, m.acceleration;
  if (lifts) x.rightCols(2) << m.angle.sin(), m.angle.cos();
  return x;
}

Series unexplained(const Motion& m, const Series& signal) {
  const Eigen::MatrixXd x = ordinary(m, m.lifts);
  const Eigen::VectorXd rest = signal.matrix() - x * x.colPivHouseholderQr().solve(signal.matrix());
  return rest.array();
}

/// What of the measured effort is friction: its part along direction and speed.
Series frictionOf(const Motion& m) {
  const Eigen::VectorXd c = ordinary(m, m.lifts).colPivHouseholderQr().solve(m.effort.matrix());
  return c[1] * m.way * m.moving + c[2] * m.speed;
}

/// What the motor gives as far as friction, inertia and a weight explain it, which most of these joints have: without
/// the sensor's noise.
Series givenEffort(const Motion& m) {
  const Eigen::MatrixXd x = ordinary(m, true);
  return (x * x.colPivHouseholderQr().solve(m.effort.matrix())).array();
}

/// How much viscous friction differs by direction before any of it is planted: plain least squares on rows that move,
/// beside a weight. \returns its value and its standard deviation (jackknife over twentieths of the log)
std::pair<double, double> ownAsymmetry(const Motion& m) {
  constexpr Index kParts = 20;
  Eigen::MatrixXd x(m.effort.size(), 7);
  x << Series::Ones(m.effort.size()), m.way, m.speed, m.acceleration, m.angle.sin(), m.angle.cos(), m.speed.abs();
  const auto without = [&](Index first, Index rows) {
    Eigen::VectorXd weight = m.moving.matrix();
    weight.segment(first, rows).setZero();
    return (weight.asDiagonal() * x).eval().colPivHouseholderQr().solve(weight.cwiseProduct(m.effort.matrix()))[6];
  };
  Series left(kParts);
  const Index rows = m.effort.size() / kParts;
  for (Index part = 0; part < kParts; ++part) left[part] = without(part * rows, rows);
  return {without(0, 0), std::sqrt((kParts - 1.0) * (left - left.mean()).square().mean())};
}

/// Effort that the effect of one magnitude adds.
struct Shape {
  std::string words;
  std::function<Series(double magnitude)> added;
  double guess = 1.0;
  std::string stated;           ///< parameter that says the magnitude, or `value`; empty: none
  std::optional<double> value;  ///< of the stated parameter where it is not the magnitude
  double unit = 1.0;            ///< of the magnitude in the stated parameter's
};

/// The effort as it was whole rows before: nothing is smoothed.
Series shifted(const Motion& m, double rows) {
  Series result = m.effort;
  const auto late = std::min<Index>(static_cast<Index>(rows), m.effort.size() / 10);
  result.tail(result.size() - late) = m.effort.head(m.effort.size() - late);
  return result;
}

/// 0 within a travel `play` from where the motion last turned round, then 1.
Series inContact(const Motion& m, double play) {
  Series result = Series::Ones(m.time.size());
  double turn = m.angle[0], farthest = m.angle[0];
  bool turned = false;
  for (Index i = 1; i < m.time.size(); ++i) {
    if (m.way[i] != m.way[i - 1]) {
      turn = farthest;
      turned = true;
      farthest = m.angle[i];
    }
    farthest = m.way[i] > 0.0 ? std::max(farthest, m.angle[i]) : std::min(farthest, m.angle[i]);
    result[i] = turned && std::fabs(m.angle[i] - turn) < play ? 0.0 : 1.0;
  }
  return result;
}

/// A temperature that goes up and down while the log lasts.
Series warmth(const Motion& m, double phase) {
  const Series s = (m.time - m.time[0]) / (m.time.maxCoeff() - m.time[0]);
  return 30.0 + 10.0 * (2.0 * std::numbers::pi * 1.5 * s + phase).sin();
}

Shape frictionShape(const Motion& m, const std::string& effect, double u, double v) {
  const Series size = m.speed.abs() / m.top, friction = frictionOf(m), dry = m.way * m.moving;
  const double dry_size = ordinary(m, m.lifts).colPivHouseholderQr().solve(m.effort.matrix())[1];
  if (effect == "viscous-asymmetry") {
    return {"|w|", [=](double c) { return Series(c * m.speed.abs() * m.moving); }, 1.0 / m.top, "k_asym", {}};
  }
  if (effect == "viscous-nonlinearity") {
    const double power = 1.5 + 1.5 * u;
    return {"w |w|^p", [=](double c) { return Series(c * dry * size.pow(power)); }, 1.0, "", {}};
  }
  if (effect == "stribeck") {
    const double scale = (0.04 + 0.06 * u) * m.top;
    return {"Lorentzian", [=](double c) { return Series(c * dry / (1.0 + (m.speed / scale).square())); }, 1.0, "", {}};
  }
  if (effect == "load-dependence") {
    return {"|sin of the angle from hanging|",
            [=](double c) { return Series(c * dry * m.angle.cos().abs()); },
            1.0,
            "",
            {}};
  }
  if (effect == "bend-friction") {
    const Series bend = m.angle - m.angle.mean();
    return {"linear in the angle", [=](double c) { return Series(c * friction * bend); }, 0.3, "", {}};
  }
  if (effect == "friction-heating") {
    const Series warm = warmth(m, 2.0 * std::numbers::pi * v) - 28.0;
    return {"hyperbolic", [=](double c) { return Series(friction * (1.0 / (1.0 + c * warm) - 1.0)); }, 0.01, "", {}};
  }
  const double from = m.time[0] + (0.3 + 0.4 * u) * (m.time.maxCoeff() - m.time[0]);
  const Series after = (m.time > from).cast<double>();
  return {"step of dry friction", [=](double c) { return Series(c * dry_size * dry * after); }, 0.2, "", {}};
}

Shape otherShape(const Motion& m, const std::string& effect, double u, double v) {
  const double pi2 = 2.0 * std::numbers::pi;
  if (effect == "joint-gravity") {
    return {"sine", [=](double c) { return Series(c * (m.angle - pi2 * u).sin()); }, 1.0, "mgl", {}};
  }
  if (effect == "position-ripple") {
    const double range = quantile(m.angle, 0.99) - quantile(m.angle, 0.01), ratio = pi2 * (5.0 + 10.0 * u) / range;
    const Series phase = ratio * m.angle + pi2 * v;
    return {"with two harmonics",
            [=](double c) {
              return Series(c * (phase.sin() + 0.5 * (2.0 * phase + 1.0).sin() + 0.25 * (3.0 * phase).sin()));
            },
            0.1, "r", ratio};
  }
  if (effect == "channel-delay") {
    return {"shift by whole rows",
            [=](double rows) { return Series(shifted(m, std::ceil(rows)) - m.effort); },
            1.0,
            "dt",
            {},
            quantile(m.time.tail(m.time.size() - 1) - m.time.head(m.time.size() - 1), 0.5)};
  }
  if (effect == "speed-limit") {
    const double limit = (0.65 + 0.2 * u) * m.top;
    return {"square above a speed",
            [=](double c) { return Series(c * m.way * (m.speed.abs() - limit).max(0.0).square()); },
            1.0,
            "",
            {}};
  }
  if (effect == "torque-saturation") {  // of what the motor gives: the sensor's noise does not saturate
    const Series given = givenEffort(m);
    const double knee = quantile(given.abs(), 0.5 + 0.3 * u);
    return {"knee", [=](double c) { return Series(c * given.sign() * (given.abs() - knee).max(0.0)); }, 0.3, "", {}};
  }
  if (effect == "backlash") {  // of the effort only its noise is left there: a sensor never reads one value for long
    const Series carried = m.effort - unexplained(m, m.effort);
    return {"dead travel",
            [=](double play) { return Series(carried * (inContact(m, play) - 1.0)); },
            0.02 * (m.angle.maxCoeff() - m.angle.minCoeff()),
            "play",
            {}};
  }
  throw std::runtime_error("no way to plant " + effect);
}

Shape shapeOf(const Motion& m, const std::string& effect, double u, double v) {
  for (const std::string_view friction : {"viscous-asymmetry", "viscous-nonlinearity", "stribeck", "load-dependence",
                                          "bend-friction", "friction-heating", "regime-change"}) {
    if (effect == friction) return frictionShape(m, effect, u, v);
  }
  return otherShape(m, effect, u, v);
}

/// The magnitude whose unexplained part has the mean square `wanted`, or the largest that a drive has.
double magnitudeOf(const Motion& m, const Shape& shape, const std::string& effect, double wanted) {
  const bool rows = effect == "channel-delay";
  const double most = effect == "torque-saturation" ? 1.5 : effect == "friction-heating" ? 0.06 : rows ? 40.0 : 1e30;
  double magnitude = shape.guess;
  for (int round = 0; round < 40; ++round) {
    // A shift of the noise is no signal: of a delay its smooth part counts.
    const Series signal = rows ? Series(magnitude * shape.unit * slope(m.time, m.effort, 6)) : shape.added(magnitude);
    const double now = unexplained(m, signal).square().mean();
    if (rows && now >= wanted) break;
    magnitude = rows ? magnitude + 1.0 : magnitude * std::sqrt(std::clamp(wanted / std::max(now, 1e-30), 0.25, 4.0));
    magnitude = std::min(magnitude, most);
  }
  return magnitude;
}

}  // namespace

const std::vector<PlantingPlan>& plantingPlans() {
  static const std::vector<PlantingPlan> plans = [] {
    const std::vector<std::string> friction = {"viscous-nonlinearity", "viscous-asymmetry", "position-ripple",
                                               "channel-delay",        "regime-change",     "friction-heating",
                                               "torque-saturation",    "speed-limit"};
    const auto with = [&](const std::vector<std::string>& more) {
      std::vector<std::string> all = friction;
      all.insert(all.end(), more.begin(), more.end());
      return all;
    };
    std::vector<PlantingPlan> list = {
        {"emps", "motor_force_N", "position_m", "", with({"stribeck"}), 4},
        {"ur10e-1", "current1_A", "q1_rad", "qd1_rad_s", with({"joint-gravity", "bend-friction", "backlash"})},
        {"ur10e-4", "current4_A", "q4_rad", "qd4_rad_s", with({"stribeck", "backlash"})},
        {"ur10e-2", "current2_A", "q2_rad", "qd2_rad_s", with({"load-dependence"})},
        {"ur10e-3", "current3_A", "q3_rad", "qd3_rad_s", friction},
        {"ur10e-all-1", "current1_A", "q1_rad", "qd1_rad_s", with({"joint-gravity"})},
        {"embir-A", "motor1_current_A", "motor1_position_rad", "motor1_velocity_rad_s", {"viscous-nonlinearity"}},
        {"embir-B", "motor1_current_A", "motor1_position_rad", "motor1_velocity_rad_s", {"viscous-asymmetry"}},
        {"robotino-1",
         "motor1_current_A",
         "motor1_speed_rad_s",
         "motor1_speed_rad_s",
         {"viscous-nonlinearity", "viscous-asymmetry", "channel-delay", "speed-limit"}}};
    return list;
  }();
  return plans;
}

LogTable LogTable::load(const std::filesystem::path& file, std::size_t every) {
  const CsvTable csv = CsvTable::load(file);
  LogTable table{csv.columns(), {}};
  for (const std::string& name : table.header) {
    std::vector<double> values;
    const std::vector<std::string> cells = csv.text(name);
    for (std::size_t i = 0; i < cells.size(); i += every) values.push_back(std::strtod(cells[i].c_str(), nullptr));
    table.columns.push_back(std::move(values));
  }
  return table;
}

std::vector<double>& LogTable::column(const std::string& name) {
  const auto found = std::ranges::find(header, name);
  if (found == header.end()) throw std::runtime_error("no column " + name);
  return columns[found - header.begin()];
}

void LogTable::append(const LogTable& more) {
  if (header.empty()) header = more.header, columns.resize(header.size());
  if (header != more.header) throw std::runtime_error("logs of different columns");
  for (std::size_t k = 0; k < columns.size(); ++k) {
    columns[k].insert(columns[k].end(), more.columns[k].begin(), more.columns[k].end());
  }
}

void LogTable::save(const std::filesystem::path& file) const {
  CsvWriter writer(header);
  for (std::size_t i = 0; i < columns[0].size(); ++i) {
    for (const std::vector<double>& values : columns) writer.add(values[i]);
    writer.endRow();
  }
  std::ofstream(file) << writer.text();
}

Planted plant(const PlantingPlan& plan, const LogTable& log, const std::string& effect, double error, double gain,
              std::uint64_t seed) {
  constexpr double kKnown = 0.05;  // of what is planted: standard deviation of a log's own
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u;
  const double first = u(random), second = u(random), side = u(random) < 0.5 ? -1.0 : 1.0;
  const Motion m = motionOf(plan, log);
  const Shape shape = shapeOf(m, effect, first, second);
  double magnitude = magnitudeOf(m, shape, effect, gain / (1.0 - gain) * error);
  if (effect == "viscous-asymmetry") magnitude *= side;
  Planted planted{log, shape.words, magnitude, {}};
  const Series with = m.effort + shape.added(magnitude);
  planted.table.column(plan.effort).assign(with.begin(), with.end());
  if (effect == "friction-heating") {
    const Series warm = warmth(m, 2.0 * std::numbers::pi * second);
    planted.table.header.emplace_back("temperature_degC");
    planted.table.columns.emplace_back(warm.begin(), warm.end());
  }
  if (!shape.stated.empty()) planted.stated = {shape.stated, shape.value.value_or(shape.unit * magnitude)};
  if (effect == "viscous-asymmetry") {
    const auto [own, deviation] = ownAsymmetry(m);
    planted.stated->second += own;
    if (deviation > kKnown * std::fabs(magnitude * shape.unit)) planted.stated.reset();  // nobody knows the sum
  }
  return planted;
}

std::vector<double> phasesRandomised(const std::vector<double>& values, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, values);
  const std::size_t n = spectrum.size();
  for (std::size_t k = 1; 2 * k < n; ++k) {
    spectrum[k] = std::polar(std::abs(spectrum[k]), phase(random));
    spectrum[n - k] = std::conj(spectrum[k]);
  }
  std::vector<double> result;
  fft.inv(result, spectrum);
  return result;
}

}  // namespace simgap::test
