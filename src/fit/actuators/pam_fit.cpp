#include "simgap/fit/actuators/pam_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "opposite_sign.h"
#include "pam_signs.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/parameter_choices.h"
#include "simgap/measure/logs/channel_checks.h"
#include "simgap/optimize/separable.h"

namespace simgap {
namespace {

using Eigen::Index;

/// The rows in use, and the model's residuals on them.
class PamProblem {
 public:
  PamProblem(const PamLog& log, const PamFitOptions& options, const std::vector<bool>& rows) : options_(options) {
    for (std::size_t i = 0; i < log.rows(); ++i) {
      if (!rows.empty() && !rows[i]) continue;
      pressure.push_back(log.pressure[i]);
      contraction.push_back(log.contraction[i]);
      force.push_back(log.force[i]);
      session.push_back(log.session[i]);
      if (!log.opposed()) continue;
      opposing_pressure.push_back(log.opposing_pressure[i]);
      opposing_contraction.push_back(log.opposing_contraction[i]);
    }
    parameters = {{"a", "m2", -kInfinity, kInfinity},
                  {"b", "m2", -kInfinity, kInfinity},
                  {"c", "m2", -kInfinity, kInfinity},
                  {"k", "N", 1.0, 1e9}};
    constrain({options.fixed, options.bounds}, parameters);
    if (!options.spring) parameters[3].fixed = true;
    if (options.tied) parameters[1].fixed = true;
    // The force of a muscle, which stretches its own tendon: measured, or of two what a rigid tendon would give.
    inside_ = force;
    opposing_inside_.assign(opposing_pressure.size(), 0.0);
    if (log.opposed()) estimateForces();
  }

  std::size_t rows() const { return force.size(); }

  LeastSquaresProblem problem() const {
    LeastSquaresProblem p;
    p.parameters = parameters;
    p.chunks = evenChunks(rows());
    p.evaluate = [this](std::span<const double> theta, const Block& block, Eigen::Ref<Eigen::VectorXd> r,
                        Eigen::Ref<Eigen::MatrixXd>* j) { evaluate(theta, block, r, j); };
    return p;
  }

  Pam muscle(std::span<const double> theta) const {
    const double k = options_.spring || options_.fixed.contains("k") ? theta[3] : kInfinity;
    return {theta[0], options_.tied ? -2.0 * theta[0] : theta[1], theta[2], k, -kInfinity, kInfinity};
  }

  /// f = p g(eps + f / k) with the measured force inside: linear in a, b, c for a given k; the first guess.
  SeparableMinimum linear(double k) const {
    SeparableProblem problem;
    problem.linear = {{"a", -kInfinity, kInfinity}, {"b", -kInfinity, kInfinity}, {"c", -kInfinity, kInfinity}};
    if (options_.tied) problem.linear.erase(problem.linear.begin() + 1);
    for (std::size_t i = 0; i < problem.linear.size(); ++i) {
      const auto fixed = options_.fixed.find(problem.linear[i].name);
      if (fixed != options_.fixed.end()) problem.linear[i].lower = problem.linear[i].upper = fixed->second;
    }
    const auto columns = static_cast<Index>(problem.linear.size());
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns + 1, columns + 1);
    for (std::size_t i = 0; i < rows(); ++i) {
      Eigen::VectorXd row(columns + 1);
      row << terms(pressure[i], contraction[i] + inside_[i] / k), force[i];
      if (!opposing_pressure.empty()) {
        row.head(columns) -= terms(opposing_pressure[i], opposing_contraction[i] + opposing_inside_[i] / k);
      }
      gram += row * row.transpose();
    }
    return {{k}, solveBounded(gram, problem.linear)};
  }

  std::vector<double> thetaOf(const SeparableMinimum& m) const {
    const Eigen::VectorXd& c = m.linear.coefficients;
    std::vector<double> theta =
        options_.tied ? std::vector{c[0], -2.0 * c[0], c[1], m.p[0]} : std::vector{c[0], c[1], c[2], m.p[0]};
    fixValues(parameters, options_.fixed, theta);
    return theta;
  }

  std::vector<double> pressure, contraction, force, opposing_pressure, opposing_contraction;
  std::vector<int> session;
  std::vector<ParameterSpec> parameters;

 private:
  /// What a, b (where it is free) and c are multiplied by in p g(x).
  Eigen::VectorXd terms(double p, double x) const {
    if (options_.tied) return Eigen::Vector2d(p * (x * x - 2.0 * x), p);
    return Eigen::Vector3d(p * x * x, p * x, p);
  }

  void estimateForces() {
    inside_.assign(rows(), 0.0);
    const std::vector<double> theta = thetaOf(linear(kInfinity));
    const Pam rigid{theta[0], theta[1], theta[2]};
    const auto estimate = [&](double p, double eps) { return std::max(0.0, p * rigid.area(eps)); };
    for (std::size_t i = 0; i < rows(); ++i) {
      inside_[i] = estimate(pressure[i], contraction[i]);
      opposing_inside_[i] = estimate(opposing_pressure[i], opposing_contraction[i]);
    }
  }

  /// Force of one muscle, and its derivatives by a, b, c, k where they are asked for.
  double pull(const Pam& m, double p, double eps, Eigen::RowVector4d* slopes) const {
    // Without a real root the spring is too soft for this point: the force at the turning point.
    const std::optional<double> root = m.force(p, eps);
    const double f = root ? *root : m.turningForce(p, eps);
    if (slopes == nullptr) return f;
    if (!root) {
      *slopes = turningSlopes(m, p, eps);
      return f;
    }
    // From F = f - p g(eps + f / k) = 0: df = -F_theta / F_f.
    const double x = eps + f / m.k, slope = 2.0 * m.a * x + m.b;
    const double stiffness = f > 0.0 ? 1.0 - p * slope / m.k : kInfinity;
    *slopes << p * (options_.tied ? x * x - 2.0 * x : x * x) / stiffness, options_.tied ? 0.0 : p * x / stiffness,
        p / stiffness, std::isfinite(m.k) ? -p * slope * f / (m.k * m.k) / stiffness : 0.0;
    return f;
  }

  void evaluate(std::span<const double> theta, const Block& block, Eigen::Ref<Eigen::VectorXd> r,
                Eigen::Ref<Eigen::MatrixXd>* jacobian) const {
    const Pam m = muscle(theta);
    for (std::size_t i = block.begin; i < block.end; ++i) {
      const auto row = static_cast<Index>(i - block.begin);
      Eigen::RowVector4d slopes, opposing = Eigen::RowVector4d::Zero();
      Eigen::RowVector4d* const wanted = jacobian == nullptr ? nullptr : &slopes;
      r[row] = pull(m, pressure[i], contraction[i], wanted) - force[i];
      if (!opposing_pressure.empty()) {
        r[row] -= pull(m, opposing_pressure[i], opposing_contraction[i], jacobian == nullptr ? nullptr : &opposing);
      }
      if (jacobian != nullptr) jacobian->row(row) = slopes - opposing;
    }
  }

  /// Derivatives of Pam::turningForce by a, b, c, k.
  Eigen::RowVector4d turningSlopes(const Pam& m, double p, double eps) const {
    const double half = 1.0 / (2.0 * m.a), by_a = m.k * half / m.a * (m.b - m.k / p);
    const double by_k = 2.0 * m.k * half / p - eps - m.b * half;
    // Tied, b = -2a moves with a, and the term of b stays what it is.
    return options_.tied ? Eigen::RowVector4d(by_a - m.k * m.b * half / m.a, 0.0, 0.0, by_k)
                         : Eigen::RowVector4d(by_a, -m.k * half, 0.0, by_k);
  }

  PamFitOptions options_;
  std::vector<double> inside_, opposing_inside_;  ///< [N]
};

/// Forces that no muscle of the model has take part in the fit all the same.
std::string impossibleForces(const PamLog& log) {
  constexpr double kOfLargest = 0.02;  // [of the largest force] what is less is noise
  if (log.of_joint) return {};
  const double least = kOfLargest * std::ranges::max(log.force);
  std::size_t pushing = 0, empty = 0;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    pushing += log.force[i] < -least ? 1 : 0;
    empty += log.pressure[i] <= 0.0 && log.force[i] > least ? 1 : 0;
  }
  if (pushing + empty == 0) return {};
  return fmt::format(
      "in {} of {} rows the muscle pushes, in {} it pulls without pressure: the model knows neither (its force is 0 "
      "there), and they pull at a, b and c; leave them out where they are not of interest",
      pushing, log.rows(), empty);
}

/// What a level that was never changed leaves open.
std::vector<const char*> unmoved(const PamLog& log, const PamFitOptions& options) {
  std::vector<const char*> sentences;
  if (isConstant(log.contraction)) {
    sentences.push_back("the contraction is constant: a, b, c and k act only together; record several lengths");
  }
  const bool one_pressure = isConstant(log.pressure) && (!log.opposed() || isConstant(log.opposing_pressure));
  if (one_pressure && !options.fixed.contains("k")) {
    sentences.push_back(
        "the pressure is constant: a tendon that stretches looks like other a, b and c, which then hold at this "
        "pressure alone; record several pressures");
  }
  return sentences;
}

/// A joint's log with its angle, its torque or both turned round.
PamLog turnedRound(PamLog log, bool angle, bool torque) {
  const auto mirror = [](std::vector<double>& values, double middle) {
    for (double& value : values) value = 2.0 * middle - value;
  };
  if (angle) mirror(log.contraction, log.rest), mirror(log.opposing_contraction, log.opposing_rest);
  if (torque) mirror(log.force, 0.0);
  return log;
}

/// No muscle pulls the harder the more it is contracted.
bool risesWithContraction(const PamFit& fit, const PamLog& log) {
  const auto [least, most] = std::ranges::minmax(log.contraction);
  return fit.theta[1] + fit.theta[0] * (least + most) > 0.0;
}

PamFit fitAsRead(const PamLog& log, const PamFitOptions& options, const std::vector<bool>& rows);

/// Which columns of a joint's log have the opposite sign: those that turned round leave the least, and less than half
/// of the squared error of the log as it is. Two of them look alike to a rigid tendon, so each is fitted. Empty: none
std::string oppositeJointSign(const PamLog& log, const PamFit& fit, const PamFitOptions& options,
                              const std::vector<bool>& rows) {
  struct Turn {
    bool angle, torque;
    double mse;
  };
  Turn best{false, false, fit.mse};
  for (Turn turn : {Turn{true, false, 0.0}, Turn{false, true, 0.0}, Turn{true, true, 0.0}}) {
    const PamLog turned = turnedRound(log, turn.angle, turn.torque);
    const PamFit other = fitAsRead(turned, options, rows);
    turn.mse = other.mse;
    if (turn.mse < best.mse && !risesWithContraction(other, turned)) best = turn;
  }
  if (!(best.mse < kOtherSign * fit.mse)) return {};
  std::string names = best.angle ? "angle_rad" : log.force_column, how = turnItRound(names);
  if (best.angle && best.torque) {
    names += " and " + log.force_column;
    how += fmt::format(", {} likewise{}", log.force_column,
                       log.opposed() ? ", or exchange the pressures if they are those of each other's muscle" : "");
  }
  return fmt::format("{} {}: turned round, a muscle explains the force to {:.3g} N, as it is to {:.3g}; {}", names,
                     best.angle && best.torque ? "have the opposite sign" : "has the opposite sign",
                     std::sqrt(best.mse), std::sqrt(fit.mse), how);
}

}  // namespace

Pam PamFit::muscle() const { return {theta[0], theta[1], theta[2], theta[3]}; }

std::optional<PamGeometry> geometryOf(double a, double c) {
  // 002 eq. 12 with q = pi D^2 / 4 and t = tan^2 psi: a = 3 q / t, c = q (2 / t - 1).
  const double q = 2.0 * a / 3.0 - c;
  if (!(q > 0.0 && a > 0.0)) return std::nullopt;
  return PamGeometry{std::sqrt(4.0 * q / std::numbers::pi), std::atan(std::sqrt(3.0 * q / a))};
}

namespace {

/// b = -2 a, and so its deviation, interval and covariances.
void tieSecond(PamFit& fit) {
  Uncertainty& u = fit.uncertainty;
  fit.theta[1] = -2.0 * fit.theta[0];
  Estimate& b = u.estimates[1];
  const Estimate& a = u.estimates[0];
  b.value = fit.theta[1], b.sd = 2.0 * a.sd, b.lower95 = -2.0 * a.upper95, b.upper95 = -2.0 * a.lower95;
  b.fixed = false;
  u.covariance.row(1) = -2.0 * u.covariance.row(0);
  u.covariance.col(1) = -2.0 * u.covariance.col(0);
  u.correlation.row(1) = -u.correlation.row(0);
  u.correlation.col(1) = -u.correlation.col(0);
}

PamFit fitAsRead(const PamLog& log, const PamFitOptions& options, const std::vector<bool>& rows) {
  // Pressures and lengths are set to levels: only their units can be checked.
  const ChannelCheck levels[] = {{"pressure_Pa", log.pressure, 1e8}, {"contraction", log.contraction, 1.0}};
  const ChannelCheck measured[] = {{"force_N", log.force, 1e6}};
  PamFit fit;
  (void)checkChannels(log.file, levels);
  fit.warnings = checkChannels(log.file, measured);
  const PamProblem model(log, options, rows);
  LeastSquaresProblem problem = model.problem();
  fit.n = model.rows();
  fit.parameters = problem.freeParameters().size();
  if (fit.n <= fit.parameters) {
    throw DataError(
        fmt::format("{}: found {} rows for {} parameters, expected many more", log.file, fit.n, fit.parameters));
  }
  if (isConstant(log.force))
    throw DataError(log.file + ": force_N is constant throughout: nothing can be found from it");
  for (const char* sentence : unmoved(log, options)) fit.warnings.emplace_back(sentence);
  if (std::string impossible = impossibleForces(log); !impossible.empty())
    fit.warnings.push_back(std::move(impossible));
  std::vector<LeastSquaresResult> found;
  if (!options.spring) {
    const double k = options.fixed.contains("k") ? options.fixed.at("k") : kInfinity;
    found.push_back(minimise(problem, model.thetaOf(model.linear(k))));
  } else {
    // k over the whole plausible range, then the best few with the model's own force.
    std::vector<SeparableMinimum> starts;
    for (int i = 0; i <= 60; ++i) starts.push_back(model.linear(std::pow(10.0, 2.0 + 0.08 * i)));
    fit.starts = starts.size();
    std::vector<SeparableMinimum> chosen;
    for (std::size_t i = 0; i < starts.size(); i += 12) chosen.push_back(starts[i]);
    chosen.push_back(*std::ranges::min_element(starts, {}, [](const auto& s) { return s.linear.cost; }));
    for (const SeparableMinimum& start : chosen) found.push_back(minimise(problem, model.thetaOf(start)));
  }
  fit.starts += found.size();
  fit.distinct_minima = rankMinima(found);
  fit.theta = found.front().theta;
  fit.mse = found.front().cost / static_cast<double>(fit.n);
  fit.uncertainty = estimateUncertainty(problem, fit.theta, model.session);
  // A tendon shows by what it stretches, f / k, and may be none at all (1 / k = 0).
  knowByInverse(fit.uncertainty.quantile, problem.parameters[3], fit.uncertainty.estimates[3]);
  if (options.tied) tieSecond(fit);
  if (!options.spring) {
    if (!options.fixed.contains("k")) fit.theta[3] = kInfinity;
    if (!options.fixed.contains("k")) fit.uncertainty.estimates.pop_back();
    const auto count = static_cast<Index>(fit.uncertainty.estimates.size());
    fit.uncertainty.covariance.conservativeResize(count, count);
    fit.uncertainty.correlation.conservativeResize(count, count);
  }
  return fit;
}

}  // namespace

PamFit fitPam(const PamLog& log, const PamFitOptions& options, const std::vector<bool>& rows) {
  PamFit fit = fitAsRead(log, options, rows);
  std::string turned = oppositePamSign(log);
  if (log.of_joint && (!turned.empty() || risesWithContraction(fit, log))) {
    turned = oppositeJointSign(log, fit, options, rows);
  }
  if (!turned.empty()) throw DataError(log.file + ": " + turned);
  return fit;
}

double predictedForce(const Pam& muscle, const PamLog& log, std::size_t row) {
  const double force = muscle.force(log.pressure[row], log.contraction[row]).value_or(0.0);
  if (!log.opposed()) return force;
  return force - muscle.force(log.opposing_pressure[row], log.opposing_contraction[row]).value_or(0.0);
}

double meanSquaredError(const PamFit& fit, const PamLog& log, const std::vector<bool>& rows) {
  Pam muscle = fit.muscle();
  muscle.lowest = -kInfinity;
  muscle.highest = kInfinity;
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    if (!rows.empty() && !rows[i]) continue;
    const double wrong = predictedForce(muscle, log, i) - log.force[i];
    sum += wrong * wrong;
    ++count;
  }
  return sum / static_cast<double>(std::max<std::size_t>(count, 1));
}

}  // namespace simgap
