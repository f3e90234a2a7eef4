#include "simgap/fit/actuators/spring_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/actuators/parameter_choices.h"
#include "simgap/measure/logs/channel_checks.h"
#include "simgap/model/actuator/fitted_model.h"

namespace simgap {
namespace {

using Eigen::Index;

constexpr std::size_t kRestLength = 3;  // place in theta

/// The rows in use, and the model's residuals on them.
class SpringProblem {
 public:
  SpringProblem(const PreparedLog& log, const SpringFitOptions& options, const std::vector<bool>& rows)
      : options_(options) {
    const ActuatorRows& all = log.data.rows;
    for (std::size_t i = 0; i < log.data.keep.size(); ++i) {
      if (!log.data.keep[i] || (!rows.empty() && !rows[i])) continue;
      const auto k = static_cast<Index>(i);
      deflection.push_back(all.deflection[k]);
      rate.push_back(all.speed[k]);
      force.push_back(all.effort[k]);
      session.push_back(all.session[i]);
    }
    const bool angular = log.data.load_unit == "Nm";
    parameters = {{"stiffness", angular ? "Nm_rad" : "N_m", 0.0, kInfinity},
                  {"offset", log.data.load_unit, -kInfinity, kInfinity},
                  {"damping", angular ? "Nms_rad" : "Ns_m", 0.0, kInfinity, !all.timed}};
    if (options.cord) parameters.push_back({"rest_length", angular ? "rad" : "m", -kInfinity, kInfinity});
    constrain({options.fixed, options.bounds}, parameters);
  }

  LeastSquaresProblem problem() const {
    LeastSquaresProblem p;
    p.parameters = parameters;
    p.chunks = evenChunks(force.size());
    p.evaluate = [this](std::span<const double> theta, const Block& block, Eigen::Ref<Eigen::VectorXd> r,
                        Eigen::Ref<Eigen::MatrixXd>* j) { evaluate(theta, block, r, j); };
    return p;
  }

  /// The line through the rows above a rest length, with the known values in place.
  std::vector<double> startAt(double rest_length) const {
    std::vector<std::size_t> taut;
    for (std::size_t i = 0; i < force.size(); ++i) {
      if (deflection[i] > rest_length) taut.push_back(i);
    }
    Eigen::MatrixXd x(std::ssize(taut), 2);
    Eigen::VectorXd f(std::ssize(taut));
    for (Index k = 0; k < f.size(); ++k) {
      const std::size_t i = taut[k];
      x.row(k) << deflection[i], 1.0;
      f[k] = force[i];
    }
    const Eigen::VectorXd line = solveLeastSquares(x, f);
    std::vector<double> theta = {std::max(line[0], 0.0), line[1], 0.0};
    if (options_.cord) theta.push_back(rest_length);
    fixValues(parameters, options_.fixed, theta);
    return theta;
  }

  std::vector<double> deflection, rate, force;
  std::vector<int> session;
  std::vector<ParameterSpec> parameters;

 private:
  void evaluate(std::span<const double> theta, const Block& block, Eigen::Ref<Eigen::VectorXd> r,
                Eigen::Ref<Eigen::MatrixXd>* jacobian) const {
    for (std::size_t i = block.begin; i < block.end; ++i) {
      const auto row = static_cast<Index>(i - block.begin);
      const bool slack = options_.cord && deflection[i] < theta[kRestLength];
      const double x = slack ? theta[kRestLength] : deflection[i], v = slack ? 0.0 : rate[i];
      r[row] = theta[0] * x + theta[1] + theta[2] * v - force[i];
      if (jacobian == nullptr) continue;
      jacobian->row(row).head(3) << x, 1.0, v;
      if (options_.cord) (*jacobian)(row, kRestLength) = slack ? theta[0] : 0.0;
    }
  }

  SpringFitOptions options_;
};

/// Rest lengths to begin with; of a spring without one, one below all rows.
std::vector<double> restLengths(const SpringProblem& model, const SpringFitOptions& options) {
  const auto [low, high] = std::ranges::minmax(model.deflection);
  if (!options.cord) return {low - 1.0};
  if (const auto fixed = options.fixed.find("rest_length"); fixed != options.fixed.end()) return {fixed->second};
  std::vector<double> starts;
  for (const double part : {0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}) starts.push_back(low + part * (high - low));
  return starts;
}

void requireFittable(const PreparedLog& log, const SpringProblem& model, std::size_t free) {
  const std::string deflection = log.data.load_unit == "Nm" ? "deflection_rad" : "the deflection";
  if (model.force.size() <= free) {
    throw DataError(
        fmt::format("{}: found {} rows for {} parameters, expected many more", log.file, model.force.size(), free));
  }
  if (isConstant(model.force)) {
    throw DataError(
        fmt::format("{}: {} is constant throughout: nothing can be found from it", log.file, log.effort_column));
  }
  requireMotion(log.file, deflection, model.deflection, model.force);
}

}  // namespace

std::vector<std::string> springParameterNames() { return {"stiffness", "offset", "damping", "rest_length"}; }

double SpringFit::force(double deflection, double rate) const {
  const bool slack = cord && deflection < theta[kRestLength];
  return theta[0] * (slack ? theta[kRestLength] : deflection) + theta[1] + (slack ? 0.0 : theta[2] * rate);
}

SpringFit fitSpring(const PreparedLog& log, const SpringFitOptions& options, const std::vector<bool>& rows) {
  const SpringProblem model(log, options, rows);
  const LeastSquaresProblem problem = model.problem();
  SpringFit fit;
  fit.cord = options.cord;
  fit.n = model.force.size();
  fit.parameters = problem.freeParameters().size();
  requireFittable(log, model, fit.parameters);
  std::vector<LeastSquaresResult> found;
  for (const double rest_length : restLengths(model, options)) {
    found.push_back(minimise(problem, model.startAt(rest_length)));
  }
  fit.starts = found.size();
  fit.distinct_minima = rankMinima(found);
  fit.theta = found.front().theta;
  fit.mse = found.front().cost / static_cast<double>(fit.n);
  fit.uncertainty = estimateUncertainty(problem, fit.theta, model.session);
  return fit;
}

double meanSquaredError(const SpringFit& fit, const PreparedLog& log, const std::vector<bool>& rows) {
  const ActuatorRows& all = log.data.rows;
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < log.data.keep.size(); ++i) {
    if (!log.data.keep[i] || (!rows.empty() && !rows[i])) continue;
    const auto k = static_cast<Index>(i);
    sum += std::pow(fit.force(all.deflection[k], all.speed[k]) - all.effort[k], 2);
    ++count;
  }
  return sum / static_cast<double>(std::max<std::size_t>(count, 1));
}

Unloaded unloadedDeflection(const SpringFit& fit) {
  if (fit.cord) return {fit.theta[kRestLength], fit.uncertainty.estimates[kRestLength].sd};
  // x_0 = -b / k: its derivatives are b / k^2 and -1 / k.
  const double k = fit.theta[0], b = fit.theta[1];
  const Eigen::Vector2d slope(b / (k * k), -1.0 / k);
  const double variance = slope.dot(fit.uncertainty.covariance.topLeftCorner<2, 2>() * slope);
  return {-b / k, variance > 0.0 ? std::sqrt(variance) : std::nan("")};
}

/// Why it is no cord below its rest length: nothing is slack there, or the force still rises. Empty where it may be.
std::string doubtOfCord(const SpringFit& fit, const PreparedLog& log) {
  constexpr double kFewestSlack = 0.02;  // of the rows
  constexpr double kFlat = 0.1;          // of the cord's stiffness
  const ActuatorRows& all = log.data.rows;
  std::vector<double> deflection, force;
  for (Index i = 0; i < all.rows(); ++i) {
    if (!log.data.keep[i] || all.deflection[i] >= fit.theta[kRestLength]) continue;
    deflection.push_back(all.deflection[i]);
    force.push_back(all.effort[i]);
  }
  const auto slack = static_cast<double>(force.size());
  if (slack < kFewestSlack * static_cast<double>(all.rows())) return "hardly a row of a cord would be slack";
  const double spread = standardDeviation(deflection);
  if (slack < 3.0 || !(spread > 0.0)) return {};
  const double r = correlation(deflection, force), slope = r * standardDeviation(force) / spread;
  const double sd = slope * std::sqrt((1.0 / (r * r) - 1.0) / (slack - 2.0));  // of a straight line's slope
  if (!(slope - 2.0 * sd > kFlat * fit.theta[0])) return {};
  return "a cord is slack below its rest length, where the force still rises";
}

SpringComparison compareSprings(const PreparedLog& log, const SpringFitOptions& options, const Holdout& holdout,
                                const std::optional<double>& block_s) {
  const ActuatorRows& rows = log.data.rows;
  const std::vector<double> time(rows.time.begin(), rows.time.end());
  const JudgedRows judged = judgedRows(
      holdout, rows.timed ? splitBlocks(time, rows.session, blockSeconds(block_s, time.back() - time.front()))
                          : splitRows(rows.session, std::max<std::size_t>(1, time.size() / 50)));
  const auto candidate = [&](const std::string& name, bool cord) {
    SpringFitOptions of = options;
    of.cord = cord;
    return fitCandidate(
        name, judged, [&](const std::vector<bool>& some) { return fitSpring(log, of, some); },
        [&](const SpringFit& fit, const std::vector<bool>& some) { return meanSquaredError(fit, log, some); });
  };
  SpringComparison comparison;
  comparison.heldout = judged.words;
  std::vector<SpringCandidate>& candidates = comparison.candidates;
  if (!options.fixed.contains("rest_length") && !options.bounds.contains("rest_length")) {
    candidates.push_back(candidate("spring", false));
  }
  candidates.push_back(candidate(kCord, true));
  comparison.choose(doubtOfCord(candidates.back().fit, log));
  return comparison;
}

}  // namespace simgap
