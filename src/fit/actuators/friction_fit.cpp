#include "simgap/fit/actuators/friction_fit.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "friction_gaps.h"
#include "friction_model.h"
#include "left_out_effects.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::Index;

constexpr double kRival = 1.01;  // of the lowest cost: minima that other rows could turn into the lowest

/// Sums over the rows of each part; parts are folds, or any split that gives every thread work.
std::vector<StribeckMoments> sumParts(const FrictionModel& model, const Eigen::VectorXd& rig, int parts) {
  const FrictionData& data = model.data();
  std::vector<StribeckMoments> sums(static_cast<std::size_t>(parts), StribeckMoments(model.shapes(), data.log_speed));
  tbb::parallel_for(0, parts, [&](int part) {
    for (std::size_t b = static_cast<std::size_t>(part); b < data.blocks.size(); b += static_cast<std::size_t>(parts)) {
      for (Block rows = {data.blocks[b].begin, 0}; rows.begin < data.blocks[b].end; rows.begin = rows.end) {
        rows.end = std::min(rows.begin + 2048, data.blocks[b].end);
        sums[part].add(data.log_speed.segment(rows.begin, rows.size()), model.columns(rig, rows));
      }
    }
  });
  return sums;
}

SeparableProblem separable(const FrictionModel& model, const StribeckMoments& moments) {
  SeparableProblem problem{model.linearTerms(), model.nonlinearTerms(), {}};
  problem.gram = [&moments](std::span<const double> p) {
    return p.empty() ? moments.gram(1.0, 1.0) : moments.gram(p[0], p[1]);
  };
  return problem;
}

/// Mean squared error on blocks the fit has not seen: every fold is predicted by a fit to the others.
std::optional<double> crossValidate(const FrictionModel& model, const std::vector<StribeckMoments>& folds,
                                    const StribeckMoments& all, const std::vector<SeparableMinimum>& minima) {
  if (folds.size() < 2) return std::nullopt;
  std::vector<double> errors(folds.size());
  tbb::parallel_for(std::size_t{0}, folds.size(), [&](std::size_t f) {
    StribeckMoments training = all;
    training.add(folds[f], -1.0);
    const SeparableProblem problem = separable(model, training);
    SeparableMinimum best;
    // Without a fifth of the rows a near rival may win.
    for (std::size_t m = 0; m < std::min<std::size_t>(minima.size(), 2); ++m) {
      if (minima[m].linear.cost > kRival * minima[0].linear.cost) break;
      SeparableMinimum found = refineSeparable(problem, minima[m].p);
      if (m == 0 || found.linear.cost < best.linear.cost) best = std::move(found);
    }
    Eigen::VectorXd a(best.linear.coefficients.size() + 1);
    a << best.linear.coefficients, -1.0;
    errors[f] = a.dot(separable(model, folds[f]).gram(best.p) * a);
  });
  const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
  return std::max(sum, 0.0) / static_cast<double>(model.data().rows());
}

/// The loss with its scale in the residual's unit, from the spread of the residuals of a least-squares fit.
Loss scaledLoss(const FrictionFitOptions& options, const Eigen::VectorXd& residual) {
  const double deviation = robustDeviation({residual.begin(), residual.end()});
  return {options.loss, options.loss_scale * std::max(deviation, 1e-12)};
}

/// The separable search, and the sums that it was made on.
struct BoxSearch {
  std::vector<StribeckMoments> parts;
  StribeckMoments total;
  SeparableResult result;
};

/// Load-dependent friction needs the load, which fitted constants of the rig change: search, take them over, again.
BoxSearch searchBox(const FrictionModel& model, int parts) {
  const int rounds = model.loadDependsOnRig() ? 4 : 1;
  Eigen::VectorXd rig = model.initialRig();
  for (int round = 1;; ++round) {
    std::vector<StribeckMoments> sums = sumParts(model, rig, parts);
    StribeckMoments total = sums[0];
    for (std::size_t k = 1; k < sums.size(); ++k) total.add(sums[k], 1.0);
    SeparableResult result = searchSeparable(separable(model, total));
    if (round == rounds) return {std::move(sums), std::move(total), std::move(result)};
    rig = model.rigOf(model.thetaOf(result.minima[0]));
  }
}

/// The lowest of the search's minima on all rows. Sets the scale of a robust loss.
LeastSquaresResult polish(const FrictionModel& model, std::span<const SeparableMinimum> minima,
                          const FrictionFitOptions& options, LeastSquaresProblem& problem) {
  LeastSquaresResult best = minimise(problem, model.thetaOf(minima[0]));
  const bool squares = options.loss == LossKind::kSquares;
  if (!squares) {
    problem.loss = scaledLoss(options, residuals(problem, best.theta));
    best = minimise(problem, best.theta);
  }
  // Bins are exact to some 1e-5 of the cost, 1e-4 where delta is large: nearer rivals have to be polished too, and all
  // under a robust loss, which the search does not know.
  LeastSquaresOptions quick;
  quick.max_iterations = 30;
  quick.function_tolerance = 1e-9;
  const double near = squares ? 1.001 * minima[0].linear.cost : kInfinity;
  for (std::size_t m = 1; m < minima.size() && minima[m].linear.cost < near; ++m) {
    const LeastSquaresResult rival = minimise(problem, model.thetaOf(minima[m]), quick);
    // Only a rival that a rough polish brings near can still win.
    if (rival.cost > (1.0 + 1e-6) * best.cost) continue;
    LeastSquaresResult polished = minimise(problem, rival.theta);
    if (polished.cost < best.cost) best = std::move(polished);
  }
  return best;
}

/// Where the lowest minimum is none, because a parameter has no bound there, the lowest of its rivals that is one.
/// \throws NumericsError: none is.
LeastSquaresResult bounded(const FrictionModel& model, std::span<const SeparableMinimum> minima,
                           const FrictionFitOptions& options, const LeastSquaresProblem& problem,
                           LeastSquaresResult best) {
  const auto fault = [&](const LeastSquaresResult& fit) {
    return degenerateFit(model, model.data(), fit.theta, options.predict_load);
  };
  const std::string sentence = fault(best);
  if (sentence.empty()) return best;
  for (std::size_t m = 1; m < minima.size() && minima[m].linear.cost < kRival * minima[0].linear.cost; ++m) {
    LeastSquaresResult rival = minimise(problem, model.thetaOf(minima[m]));
    if (fault(rival).empty()) return rival;
  }
  throw NumericsError(fmt::format("{}: {}", model.data().file, sentence));
}

/// What a user is told of what was left out. \param acceleration  shape (rows)
void sayWhatWasLeftOut(const LeftOutEffect& effect, const FrictionData& data, const Eigen::ArrayXd& acceleration,
                       FrictionFit& fit) {
  constexpr double kWorthSaying = 0.05;  // rows, and of the deviation that the fit leaves
  const std::string target = fit.predict_load ? "the load" : data.effort_name;
  constexpr const char* kHow = "the intervals allow for it; simgap diagnose tells whether it";
  const double rows = effect.value[kDelay] / rowSeconds(data);
  if (std::abs(rows) >= kWorthSaying) {
    fit.warnings.push_back(fmt::format("{} seems to come {:.2g} ms ({:.2f} rows) {} than load and motion: {} does",
                                       target, 1e3 * std::abs(effect.value[kDelay]), std::abs(rows),
                                       rows > 0.0 ? "later" : "earlier", kHow));
  }
  const Eigen::ArrayXd part = std::abs(effect.value[kInertia]) * acceleration.abs();
  if (part.square().mean() < kWorthSaying * kWorthSaying * fit.mse) return;
  fit.warnings.push_back(
      fmt::format("{} goes with the acceleration besides, by up to {:.2g} {}, as where a rotor's inertia is not in the "
                  "load: {} is one",
                  target, part.maxCoeff(), fit.predict_load ? data.load_unit : data.effort_unit, kHow));
}

/// Widens intervals by where the estimates would lie had the fit known of a delay of the target, or of an inertia that
/// is not in the load, if one is seen. The estimates stay those of least squares: what it is only a diagnosis can tell.
void allowForLeftOut(const LeastSquaresProblem& problem, const FrictionData& data, FrictionFit& fit) {
  const Eigen::ArrayXd& target = fit.predict_load ? data.load : data.effort;
  const Eigen::ArrayXd acceleration = slopeOfVelocity(data);
  const LeastSquaresProblem with = withLeftOut(problem, data, target, acceleration, fit.theta);
  std::vector<double> theta = fit.theta;
  theta.resize(theta.size() + kLeftOut.size(), 0.0);
  const std::optional<LeftOutEffect> effect = leftOutEffect(with, theta, data.session);
  if (!effect) return;
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(std::ssize(fit.theta));
  for (std::size_t i = 0; i < fit.theta.size(); ++i) {
    Estimate& e = fit.uncertainty.estimates[i];
    if (e.fixed || !e.identifiable || e.at_bound) continue;
    const double half = fit.uncertainty.quantile * e.sd * effect->widening[i];
    const double center = e.value + effect->shift[i];
    e.lower95 = std::clamp(center - half, problem.parameters[i].lower, e.lower95);
    e.upper95 = std::clamp(center + half, e.upper95, problem.parameters[i].upper);
    shift[i] = effect->shift[i];
    e.sd = std::hypot(e.sd, shift[i]);
  }
  Eigen::MatrixXd& covariance = fit.uncertainty.covariance;
  covariance += shift * shift.transpose();
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  fit.uncertainty.correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  fit.uncertainty.correlation.diagonal().setOnes();
  sayWhatWasLeftOut(*effect, data, acceleration, fit);
}

/// Where v_s and delta are hardly known, what is likely is no ellipse, and lies in several valleys: intervals hold the
/// fits at all places of the searched box, too, that the likelihood ratio lets stand at 95 % (Wilks 1938).
void holdLikelyPlaces(const FrictionModel& model, const BoxSearch& search, FrictionFit& fit) {
  constexpr double kUnlikely = 3.84;  // chi^2 with one degree of freedom, 95 %
  const SeparableProblem problem = separable(model, search.total);
  const CostProfile& profile = search.result.profile;
  const double enough = (1.0 + kUnlikely / fit.uncertainty.n_effective) * search.result.minima[0].linear.cost;
  for (std::size_t place = 0; place < profile.cost.size(); ++place) {
    if (profile.cost[place] > enough) continue;
    SeparableMinimum at{profile.at(place), {}};
    at.linear = solveBounded(problem.gram(at.p), problem.linear);
    const std::vector<double> theta = model.thetaOf(at);
    for (std::size_t i = 0; i < theta.size(); ++i) {
      Estimate& e = fit.uncertainty.estimates[i];
      if (e.fixed || !e.identifiable) continue;
      e.lower95 = std::min(e.lower95, theta[i]);
      e.upper95 = std::max(e.upper95, theta[i]);
      e.sd = std::max(e.sd, 0.5 * (e.upper95 - e.lower95) / fit.uncertainty.quantile);
    }
  }
  constexpr double kAnySize = 1e50;  // in no unit a drive's
  for (Estimate& e : fit.uncertainty.estimates) {
    if (!(e.upper95 - e.lower95 > kAnySize)) continue;
    e.identifiable = false;
    e.sd = e.lower95 = e.upper95 = std::nan("");
  }
  fit.uncertainty.findings = describeUndetermined(fit.uncertainty);
}

}  // namespace

double FrictionFit::value(std::string_view name) const {
  for (const Estimate& e : uncertainty.estimates) {
    if (e.name == name) return e.value;
  }
  return 0.0;
}

LeastSquaresProblem makeFrictionProblem(const FrictionLaw& law, const FrictionData& data,
                                        const FrictionFitOptions& options) {
  return FrictionModel(law, data, options).problem();
}

FrictionFit fitFriction(const FrictionLaw& law, const FrictionData& data, const FrictionFitOptions& options) {
  const FrictionModel model(law, data, options);
  if (const std::string sentence = missingForLaw(model, data, options.predict_load); !sentence.empty()) {
    throw DataError(fmt::format("{}: {}", data.file, sentence));
  }
  FrictionFit fit;
  fit.law = &law;
  fit.predict_load = options.predict_load;
  fit.n = data.rows();
  fit.parameters = model.freeCount();

  const int blocks = static_cast<int>(data.blocks.size());
  const int folds = std::min(options.folds, blocks);
  const BoxSearch search = searchBox(model, folds >= 2 ? folds : std::max(folds, std::min(8, blocks)));
  // Without a Stribeck term the problem is convex: one start is all there is.
  fit.starts = law.hasStribeck() ? search.result.starts + search.result.minima.size() : 1;
  fit.minima = search.result.minima;
  fit.profile = search.result.profile;

  LeastSquaresProblem problem = model.problem();
  const LeastSquaresResult best =
      bounded(model, fit.minima, options, problem, polish(model, fit.minima, options, problem));
  fit.theta = best.theta;
  const bool squares = options.loss == LossKind::kSquares;
  fit.mse = (squares ? best.cost : residuals(problem, fit.theta).squaredNorm()) / static_cast<double>(fit.n);
  if (!best.converged)
    fit.warnings.push_back(fmt::format("the polish of {} stopped early: {}", law.name, best.message));
  fit.uncertainty = estimateUncertainty(problem, fit.theta, data.session);
  allowForLeftOut(problem, data, fit);
  if (squares) holdLikelyPlaces(model, search, fit);
  if (folds >= 2) fit.mse_heldout = crossValidate(model, search.parts, search.total, fit.minima);
  for (const std::string& sentence : motionGaps(model, data, fit.theta)) fit.warnings.push_back(sentence);
  const auto weight = data.fits_weight
                          ? std::ranges::find(fit.uncertainty.estimates, data.rig_names.front(), &Estimate::name)
                          : fit.uncertainty.estimates.end();
  if (weight != fit.uncertainty.estimates.end() && weight->at_bound) {
    fit.warnings.push_back(weightlessSentence(weight->name));
  }
  return fit;
}

double meanSquaredError(const FrictionFit& fit, const FrictionData& data, const FrictionFitOptions& options) {
  const LeastSquaresProblem problem = makeFrictionProblem(*fit.law, data, options);
  return residuals(problem, fit.theta).squaredNorm() / static_cast<double>(data.rows());
}

Eigen::ArrayXd predictEffort(const LeastSquaresProblem& problem, const FrictionFit& fit, const FrictionData& data,
                             const FrictionFitOptions& options, const Block& rows) {
  const Eigen::ArrayXd& measured = options.predict_load ? data.load : data.effort;
  Eigen::VectorXd predicted(static_cast<Index>(rows.size()));
  problem.evaluate(fit.theta, rows, predicted, nullptr);
  return predicted.array() + measured.segment(rows.begin, rows.size());
}

Eigen::ArrayXd predictEffort(const FrictionFit& fit, const FrictionData& data, const FrictionFitOptions& options,
                             const Block& rows) {
  return predictEffort(makeFrictionProblem(*fit.law, data, options), fit, data, options, rows);
}

std::size_t compareFits(std::vector<FrictionFit>& fits) {
  const auto best_mse = std::ranges::min_element(fits, {}, &FrictionFit::mse);
  // One effective sample size for all, from the model that leaves the least structure behind.
  const double n = best_mse->uncertainty.n_effective;
  for (FrictionFit& fit : fits) {
    fit.bic = n * std::log(std::max(fit.mse, 1e-300)) + static_cast<double>(fit.parameters) * std::log(n);
  }
  const auto best = std::ranges::min_element(fits, {}, &FrictionFit::bic);
  return static_cast<std::size_t>(best - fits.begin());
}

}  // namespace simgap
