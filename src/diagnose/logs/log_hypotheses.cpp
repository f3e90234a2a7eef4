#include "log_hypotheses.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/interrupt.h"
#include "simgap/core/ranks.h"
#include "simgap/measure/logs/log_kind.h"
#include "trial_tests.h"

namespace simgap {
namespace {

using Eigen::Index;
using Kind = EffectParameter::Kind;

constexpr int kFolds = 5;
/// The presliding that every drive has: within this share of the typical travel between two rows.
constexpr double kNuisancePresliding = 0.1;
/// An effect whose signature is within that share of what the model's own parameters span is no finding of its own.
constexpr double kAliased = 1e-3;
/// Two causes that differ by less than that share of the error say the same in other words.
constexpr double kSameEquation = 1e-4;
/// Of what the other adds: so little says nothing new.
constexpr double kAddsNothing = 0.2;
/// Of what a cause explains alone: a rival beside which that is left explains something else.
constexpr double kMostOfAlone = 0.5;
constexpr std::size_t kToTheEnd = 2;  // starts
/// Of the least gain: what a cause has to promise to be fitted at all.
constexpr double kHopeless = 0.2;

std::vector<const ActuatorEffect*> withOneMore(std::vector<const ActuatorEffect*> effects, const ActuatorEffect* more) {
  effects.push_back(more);
  return effects;
}

}  // namespace

LogSearch::LogSearch(const ActuatorBase& base, const ActuatorData& data, std::vector<Block> training,
                     const LogDiagnosisOptions& options)
    : base_(base), data_(data), training_(std::move(training)), folds_(kFolds), options_(options) {
  for (std::size_t b = 0; b < training_.size(); ++b) folds_[b % kFolds].push_back(training_[b]);
  training_rows_ = rowsIn(training_, data_.keep);
  if (training_rows_ >= 2.0 * kFewRows) few_ = fewRowsOf(data_, training_, kFewRows);
}

std::shared_ptr<const ActuatorRegression> LogSearch::makeModel(
    const std::vector<const ActuatorEffect*>& effects) const {
  const bool named = std::ranges::any_of(effects, [](const ActuatorEffect* effect) { return effect->in_every_drive; });
  const double typical = std::sqrt(data_.rows.speed.square().mean()) * data_.rows.step;
  std::optional<double> nuisance;
  if (kindOf(base_.kind).is_drive && !named) nuisance = std::max(kNuisancePresliding * typical, 1e-5);
  return std::make_shared<const ActuatorRegression>(base_, effects, data_, nuisance);
}

LogSearch::Rough LogSearch::roughly(std::shared_ptr<const ActuatorRegression> model) const {
  if (!few_ || std::ranges::any_of(model->effects(), &ActuatorEffect::needs_all_rows)) {
    return {std::move(model), training_};
  }
  return {std::make_shared<const ActuatorRegression>(model->on(few_->data)), few_->blocks};
}

std::vector<LogSearch::Start> LogSearch::ranked(const Rough& rough, const std::vector<std::vector<double>>& starts,
                                                bool always) const {
  constexpr std::size_t kMost = 8;
  const auto& [model, blocks] = rough;
  std::vector<Start> ranked;
  for (std::vector<double> theta : starts) {
    for (std::size_t i = model->linear(); i < theta.size(); ++i) {
      theta[i] = std::clamp(theta[i], model->parameters()[i].lower, model->parameters()[i].upper);
    }
    double cost = 0.0;
    theta = model->solveCoefficients(std::move(theta), blocks, &cost);
    ranked.push_back({cost, std::move(theta)});
  }
  if (few_) {  // of many those that leave least as they are, and what leaves as little
    std::ranges::stable_sort(ranked, {}, &Start::cost);
    while (ranked.size() > kMost && ranked.back().cost > ranked[kMost - 1].cost) ranked.pop_back();
  }
  for (Start& start : ranked) {
    stopIfInterrupted();
    const bool choose = always || ranked.size() > kToTheEnd;
    start.cost = choose ? linearisedCost(*model, blocks, start.theta) : 0.0;
  }
  std::ranges::stable_sort(ranked, {}, &Start::cost);
  return ranked;
}

Fitted LogSearch::fitFromStarts(std::shared_ptr<const ActuatorRegression> model, const Rough& rough,
                                const std::vector<std::vector<double>>& starts, const Fitted* base) const {
  const bool all = rough.model == model;
  std::vector<Start> best = ranked(rough, starts, /*always=*/base != nullptr);
  const double rest = base == nullptr ? 0.0
                      : all           ? base->mse * training_rows_
                                      : linearisedCost(base->model->on(few_->data), rough.blocks, base->theta);
  // Most causes change nothing: the linearised model says so without a fit, few rows without all of them.
  const auto hopeless = [&](double cost) {
    return base != nullptr && cost > (1.0 - kHopeless * options_.least_gain) * rest;
  };
  const auto left = [&](double cost) { return cost / rest * base->mse; };
  if (hopeless(best[0].cost)) return {model, best[0].theta, left(best[0].cost), {}, {}};
  best.resize(std::min(best.size(), kToTheEnd));
  RowFit fit;
  for (std::size_t k = 0; k < best.size(); ++k) {
    RowFit one = fitRows(*rough.model, rough.blocks, best[k].theta);
    if (k == 0 || one.cost < fit.cost) fit = std::move(one);
  }
  if (!all && hopeless(fit.cost)) return {model, fit.theta, left(fit.cost), {}, {}};
  if (!all) fit = fitRows(*model, training_, std::move(fit.theta));
  return {model, fit.theta, fit.cost / training_rows_, {}, {}};
}

Fitted LogSearch::fit(const std::vector<const ActuatorEffect*>& effects, const Fitted* near) const {
  const auto model = makeModel(effects);
  if (near != nullptr) return fitFromStarts(model, {model->startFrom(*near->model, near->theta)});
  std::vector<std::vector<double>> starts;
  std::vector<double> start(model->parameters().size(), 0.0);
  start = model->startFrom(*model, start);
  for (std::size_t i = 0; i < start.size(); ++i) {
    start[i] = std::clamp(0.01, model->parameters()[i].lower, model->parameters()[i].upper);
    if (model->parameters()[i].name == kNuisance) start[i] = 0.1 * model->parameters()[i].upper;
    if (model->parameters()[i].name == kAngleOffset) start[i] = data_.angle->start;
  }
  start[0] = 1.0;
  std::vector<std::vector<double>> own = {{}};
  for (std::size_t e = 0; e < effects.size(); ++e) {
    const std::size_t first = model->firstParameter(e), columns = model->firstColumn(e);
    for (std::size_t k = 0; k < effects[e]->columns.size(); ++k) start[columns + k] = 0.0;
    for (std::size_t k = 0; k < effects[e]->parameters.size(); ++k) start[first + k] = effects[e]->parameters[k].start;
  }
  const std::size_t speed = model->linear();
  if (kindOf(base_.kind).fits_in_turn && !effects.empty()) return fitInTurn(effects);
  const Rough whole{model, training_};  // all else starts from here
  if (!base_.hasStribeck()) return fitFromStarts(model, whole, {start}, nullptr);
  for (const double v_s : {0.003, 0.01, 0.03, 0.1, 0.3, 1.0}) {
    for (const double delta : {0.6, 1.0, 2.0}) {
      start[speed] = v_s * data_.rows.top_speed;
      start[speed + 1] = delta;
      starts.push_back(start);
    }
  }
  return fitFromStarts(model, whole, starts, nullptr);
}

Fitted LogSearch::fitInTurn(const std::vector<const ActuatorEffect*>& effects) const {
  Fitted fitted = fit({}, nullptr);
  validate(fitted);
  for (const ActuatorEffect* effect : effects) fitted = tryOne(fitted, {effect, {}, {}}, nullptr).fitted;
  return fit(effects, &fitted);
}

Fitted LogSearch::fitFrom(const std::vector<const ActuatorEffect*>& effects, std::span<const Estimate> values) const {
  const auto model = makeModel(effects);
  std::vector<std::vector<double>> starts{model->thetaOf(values)};
  if (auto other = otherStribeck(roughly(model), starts[0])) starts.push_back(std::move(*other));
  return fitFromStarts(model, starts);
}

Eigen::VectorXd LogSearch::refittedResidual(const Fitted& fitted, const std::vector<Block>& blocks,
                                            const RowEvaluation& at) const {
  // Without a part of many rows the minimum is hardly elsewhere: one step leads there.
  const int most = few_ ? 1 : 3;
  const RowFit fit = fitRows(*fitted.model, blocks, fitted.theta, {.max_iterations = most, .tolerance = 1e-5}, &at);
  return residualOf(fitted, fit.theta);
}

void LogSearch::validate(Fitted& fitted, const RowEvaluation& at) const {
  fitted.unseen = Eigen::VectorXd::Zero(data_.rows.rows());
  tbb::parallel_for(0, kFolds, [&](int f) {
    std::vector<Block> others;
    for (int g = 0; g < kFolds; ++g) {
      if (g != f) others.insert(others.end(), folds_[g].begin(), folds_[g].end());
    }
    const Eigen::VectorXd residual = refittedResidual(fitted, others, at);
    for (const Block& b : folds_[f]) {
      const auto begin = static_cast<Index>(b.begin), size = static_cast<Index>(b.size());
      fitted.unseen.segment(begin, size) = residual.segment(begin, size);
    }
  });
  fitted.validation = errors(fitted.unseen, training_, kPieceSeconds);
}

std::vector<std::size_t> LogSearch::bestStarts(const Rough& rough,
                                               const std::vector<std::vector<double>>& starts) const {
  constexpr std::size_t kFew = 4;
  std::vector<std::pair<double, std::size_t>> costs;
  for (std::size_t s = 0; s < starts.size(); ++s) {
    costs.emplace_back(0.0, s);
    if (starts.size() > kFew) rough.model->solveCoefficients(starts[s], rough.blocks, &costs.back().first);
  }
  std::ranges::sort(costs);
  std::vector<std::size_t> best;
  for (std::size_t k = 0; k < std::min(kFew, costs.size()); ++k) best.push_back(costs[k].second);
  return best;
}

std::optional<std::vector<double>> LogSearch::otherStribeck(const Rough& rough,
                                                            const std::vector<double>& start) const {
  if (!base_.hasStribeck()) return std::nullopt;
  const auto& [model, blocks] = rough;
  double lowest = 0.0;
  model->solveCoefficients(start, blocks, &lowest);
  lowest *= 1.0 - 0.5 * options_.least_gain;
  std::optional<std::vector<double>> best;
  for (const double v_s : {0.01, 0.03, 0.1, 0.3}) {
    for (const double delta : {0.8, 1.6}) {
      std::vector<double> other = start;
      other[model->linear()] = v_s * data_.rows.top_speed;
      other[model->linear() + 1] = delta;
      double cost = 0.0;
      other = model->solveCoefficients(std::move(other), blocks, &cost);
      if (cost >= lowest) continue;
      lowest = cost;
      best = std::move(other);
    }
  }
  return best;
}

void LogSearch::refineScanned(Fitted& fitted, const std::vector<std::vector<double>>& starts) const {
  const std::size_t e = fitted.model->effects().size() - 1;
  const std::size_t first = fitted.model->firstParameter(e);
  if (starts.size() < 2) return;
  for (std::size_t k = 0; k < fitted.model->effects()[e]->parameters.size(); ++k) {
    const bool scanned = fitted.model->effects()[e]->parameters[k].kind == Kind::kScanned;
    const bool has_valleys = fitted.model->isDelay(fitted.theta, first + k);  // between rows
    if (!scanned && !has_valleys) continue;
    double width = std::abs(starts[1][first + k] - starts[0][first + k]);
    for (int round = 0; round < 4; ++round, width /= 3.0) {
      std::vector<std::vector<double>> near;
      for (const double t : {-0.67, -0.33, 0.33, 0.67}) {
        near.push_back(fitted.theta);
        near.back()[first + k] += t * width;
      }
      Fitted trial = fitFromStarts(fitted.model, near);
      if (trial.mse < fitted.mse) fitted = std::move(trial);
    }
  }
}

Trial LogSearch::tryOne(const Fitted& base, const Hypothesis& hypothesis, const Fitted* near) const {
  Trial trial;
  trial.hypothesis = hypothesis;
  const std::vector<const ActuatorEffect*> effects = withOneMore(base.model->effects(), hypothesis.effect);
  const auto model = makeModel(effects);
  const std::size_t first = model->firstParameter(effects.size() - 1);
  std::vector<std::vector<double>> origins = {model->startFrom(*base.model, base.theta)}, starts;
  if (near != nullptr) origins.push_back(model->startFrom(*near->model, near->theta));
  const auto startAt = [&](std::vector<double> start, const std::vector<double>& own) {
    std::ranges::copy(own, start.begin() + static_cast<std::ptrdiff_t>(first));
    starts.push_back(std::move(start));
  };
  std::vector<std::vector<double>> own = {hypothesis.fixed};
  if (hypothesis.effect->starts != nullptr && hypothesis.fixed.empty()) {
    own = hypothesis.effect->starts(data_.rows, residualOf(base).array());
    if (near != nullptr) startAt(origins.back(), {});
  }
  for (const std::vector<double>& origin : origins) {
    for (const std::vector<double>& p : own) startAt(origin, p);
  }
  if (hypothesis.effect->in_every_drive) {  // and where the nuisance was
    const auto nuisance = std::ranges::find(base.model->parameters(), kNuisance, &ParameterSpec::name);
    startAt(origins[0], {base.theta[nuisance - base.model->parameters().begin()]});
  }
  if (starts.empty()) return trial;
  const Rough rough = roughly(model);
  for (const std::size_t s : bestStarts(rough, starts)) {
    if (auto other = otherStribeck(rough, starts[s])) starts.push_back(std::move(*other));
  }
  trial.fitted = fitFromStarts(model, starts, &base);
  trial.gain_training = 1.0 - trial.fitted.mse / base.mse;
  if (trial.gain_training < 0.5 * options_.least_gain) return trial;
  refineScanned(trial.fitted, starts);
  trial.gain_training = 1.0 - trial.fitted.mse / base.mse;
  const RowEvaluation at(*model, trial.fitted.theta);
  trial.identifiable = distinctShare(*model, at, training_, effects.size() - 1) > kAliased;
  if (!trial.identifiable) return trial;
  const std::span<const double> p(trial.fitted.theta.data() + first, hypothesis.effect->parameters.size());
  if (hypothesis.effect->counts != nullptr && !hypothesis.effect->counts(p, data_.rows)) return trial;
  validate(trial.fitted, at);
  const Eigen::ArrayXd shared = (trial.fitted.unseen.array() != 0.0).cast<double>();  // a delay counts others
  const GroupErrors before = errors((base.unseen.array() * shared).matrix(), training_, kPieceSeconds);
  trial.gain = pairedGain(before, trial.fitted.validation, options_.seed);
  trial.p_paired = nestedP(added(base.unseen, trial.fitted.unseen, training_));
  trial.fitted.unseen.resize(0);  // of many trials one is chosen
  trial.p = std::min(1.0, 2.0 * std::min(trial.p_paired, waldP(*model, at, pieces(training_))));
  return trial;
}

std::vector<Trial> LogSearch::tryAll(Fitted base, const std::vector<Hypothesis>& hypotheses, const Fitted* near) const {
  if (base.unseen.size() == 0) validate(base);
  std::vector<Trial> trials(hypotheses.size());
  Bytes digest;
  pack(digest, base.theta);
  const auto tryThis = [&](std::size_t h) { return tryOne(base, hypotheses[h], near); };
  computeOnRanks(std::span(trials), tryThis, /*one_by_one=*/false, std::move(digest));
  for (std::size_t h = 0; h < trials.size(); ++h) {  // pointers stay on the rank that made them
    trials[h].hypothesis = hypotheses[h];
    if (trials[h].fitted.model || trials[h].fitted.theta.empty()) continue;
    const std::vector<const ActuatorEffect*> effects = withOneMore(base.model->effects(), hypotheses[h].effect);
    trials[h].fitted.model = makeModel(effects);
  }
  return trials;
}

bool LogSearch::encompasses(const Trial& winner, const Trial& rival) const {
  const std::vector<const ActuatorEffect*> effects =
      withOneMore(rival.fitted.model->effects(), winner.hypothesis.effect);
  const auto model = makeModel(effects);
  std::vector<double> from_rival = model->startFrom(*rival.fitted.model, rival.fitted.theta);
  std::vector<double> from_winner = model->startFrom(*winner.fitted.model, winner.fitted.theta);
  const std::size_t first = model->firstParameter(effects.size() - 1);
  for (std::size_t k = 0; k < winner.hypothesis.effect->parameters.size(); ++k) {
    from_rival[first + k] = from_winner[first + k];  // its reference values
  }
  const Fitted both = fitFromStarts(model, {from_winner, from_rival});
  const double rival_adds = winner.fitted.mse - both.mse, winner_adds = rival.fitted.mse - both.mse;
  const double alone = winner.fitted.mse / (1.0 - winner.gain_training) - winner.fitted.mse;
  if (winner_adds < kSameEquation * both.mse) return false;
  const bool says_more = rival_adds<kAddsNothing * winner_adds, says_else = winner_adds> kMostOfAlone * alone;
  return (says_more || says_else) && waldP(*model, {*model, both.theta}, pieces(training_)) < options_.level;
}

Fitted LogSearch::without(const Fitted& fitted, std::size_t effect) const {
  std::vector<const ActuatorEffect*> effects = fitted.model->effects();
  effects.erase(effects.begin() + static_cast<std::ptrdiff_t>(effect));
  return fit(effects, &fitted);
}

Fitted LogSearch::beside(const Fitted& fitted, const Hypothesis& other, const Fitted* near) const {
  const std::vector<const ActuatorEffect*> effects = withOneMore(fitted.model->effects(), other.effect);
  const auto model = makeModel(effects);
  std::vector<std::vector<double>> starts = {model->startFrom(*fitted.model, fitted.theta)};
  if (near != nullptr) starts.push_back(model->startFrom(*near->model, near->theta));
  const std::size_t first = model->firstParameter(effects.size() - 1);
  for (std::vector<double>& start : starts) {
    std::ranges::copy(other.fixed, start.begin() + static_cast<std::ptrdiff_t>(first));
  }
  if (auto curve = otherStribeck(roughly(model), starts[0])) starts.push_back(std::move(*curve));
  return fitFromStarts(model, starts);
}

Eigen::MatrixXd LogSearch::refit(Fitted& fitted, const std::vector<Block>& blocks) const {
  const RowFit fit = fitRows(*fitted.model, blocks, fitted.theta);
  fitted.theta = fit.theta;
  fitted.mse = fit.cost / rowsIn(blocks, data_.keep);
  // What a model gets slightly wrong lasts for a whole motion: pieces would take it for many independent errors.
  constexpr std::size_t kBlocksPerParameter = 3;
  const bool enough = blocks.size() >= kBlocksPerParameter * fitted.theta.size();
  return blockCovariance(*fitted.model, enough ? blocks : pieces(blocks), {*fitted.model, fitted.theta});
}

}  // namespace simgap
