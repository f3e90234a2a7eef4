#include "self_test.h"

#include <algorithm>
#include <cmath>

#include "diagnose/verdict.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"
#include "simgap/core/ranks.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kHiddenGain = 0.08;

/// Residuals of whole blocks in a random order, so that the noise keeps its correlation and size.
ArrayXd resampled(const PreparedLog& log, const Eigen::VectorXd& residual, const CounterRandom& random,
                  std::uint32_t draw) {
  std::vector<double> noise;
  for (Index i = 0; i < residual.size(); ++i) {
    if (residual[i] != 0.0) noise.push_back(residual[i]);
  }
  ArrayXd result = ArrayXd::Zero(residual.size());
  for (std::size_t b = 0; b < log.blocks.size() && !noise.empty(); ++b) {
    const double u = random.uniform({.generation = draw, .individual = static_cast<std::uint32_t>(b), .purpose = 1});
    auto from = static_cast<std::size_t>(u * static_cast<double>(noise.size()));
    for (std::size_t i = log.blocks[b].begin; i < log.blocks[b].end; ++i) {
      result[i] = noise[from++ % noise.size()];
    }
  }
  return result;
}

/// theta of the model with the effect at a size that is to be found.
std::vector<double> hide(const ActuatorRegression& model, const Fitted& fitted, const ActuatorRows& rows,
                         double magnitude, double sign) {
  const std::size_t e = model.effects().size() - 1;
  const ActuatorEffect& effect = *model.effects()[e];
  std::vector<double> theta = model.startFrom(*fitted.model, fitted.theta);
  const auto p = theta.begin() + static_cast<std::ptrdiff_t>(model.firstParameter(e));
  if (effect.starts != nullptr) {
    const Eigen::VectorXd residual = residualOf(fitted);
    const auto starts = effect.starts(rows, residual.array());
    if (!starts.empty()) std::ranges::copy(starts[starts.size() / 2], p);
  }
  const std::size_t i = effect.columns.empty() ? model.firstParameter(e) : model.firstColumn(e);
  const double neutral = effect.columns.empty() ? effect.parameters[0].neutral : 0.0;
  const double size = effect.columns.empty() || !effect.columns[0].torque ? magnitude : magnitude * theta[0];
  const ParameterSpec& bounds = model.parameters()[i];
  theta[i] = std::clamp(neutral + sign * size, bounds.lower, bounds.upper);
  if (theta[i] == neutral || bounds.lower >= neutral) theta[i] = std::clamp(neutral + size, bounds.lower, bounds.upper);
  const std::span<const double> own(&*p, effect.parameters.size());
  while (effect.counts != nullptr && !effect.counts(own, rows)) theta[i] = neutral + 2.0 * (theta[i] - neutral);
  return theta;
}

std::string answerOf(const Selection& selection, std::size_t own) {
  const auto& effects = selection.chosen.model->effects();
  if (effects.size() == own) return selection.unnamed ? "unexplained" : "nothing";
  if (!selection.ambiguous_with[0].empty()) return "ambiguous";
  return effects.size() > own + 1 ? "several" : std::string(effects[own]->name);
}

}  // namespace

SelfTest runSelfTest(const ActuatorModel& subject, const PreparedLog& log, const Fitted& fitted,
                     const std::vector<Hypothesis>& named, const std::vector<Hypothesis>& unnamed,
                     const std::vector<Detectable>& detectable, double effective_samples,
                     const LogDiagnosisOptions& options, const std::vector<Block>& training,
                     const DiagnosisProgress& progress) {
  SelfTest test;
  test.hidden = {"none"};
  std::vector<const ActuatorEffect*> hidden = {nullptr};
  std::vector<double> magnitudes = {0.0};
  const double factor = detectionFactor(options.least_gain, effective_samples);
  for (const Detectable& d : detectable) {
    test.hidden.push_back(d.effect);
    hidden.push_back(&actuator_effects::find(d.effect));
    magnitudes.push_back(d.magnitude95 / factor * std::sqrt(kHiddenGain / (1.0 - kHiddenGain) * effective_samples));
  }
  test.answers = {"nothing"};
  for (const Hypothesis& h : named) test.answers.emplace_back(h.effect->name);
  for (const char* other : {"ambiguous", "several", "unexplained"}) test.answers.emplace_back(other);
  test.count.assign(test.hidden.size(), std::vector<int>(test.answers.size(), 0));
  const Eigen::VectorXd residual = residualOf(fitted);
  const CounterRandom random(options.seed);
  const std::size_t runs = hidden.size() * static_cast<std::size_t>(options.self_tests);
  PreparedLog copy = log;
  const std::vector<const ActuatorEffect*>& own = fitted.model->effects();
  const auto runOne = [&](std::size_t k) {
    if (progress) progress("self-test", static_cast<double>(k) / static_cast<double>(runs));
    const std::size_t h = k % hidden.size();
    const auto draw = static_cast<std::uint32_t>(k);
    copy.data.rows.effort = fitted.model->predict(fitted.theta);
    if (hidden[h] != nullptr) {
      std::vector<const ActuatorEffect*> effects = fitted.model->effects();
      effects.push_back(hidden[h]);
      const ActuatorRegression model(subject.base, effects, log.data, std::nullopt);
      const double sign = random.uniform({.generation = draw, .purpose = 2}) < 0.5 ? -1.0 : 1.0;
      copy.data.rows.effort = model.predict(hide(model, fitted, log.data.rows, magnitudes[h], sign));
    }
    copy.data.rows.effort += resampled(log, residual, random, draw);
    const LogSearch search(subject.base, copy.data, training, options);
    return answerOf(selectCauses(search, own, named, unnamed, options, {}), own.size());
  };
  std::vector<std::string> answers(runs);
  computeOnRanks(std::span(answers), runOne, /*one_by_one=*/true);
  stopIfInterrupted();
  for (std::size_t k = 0; k < runs; ++k) {
    const auto column = std::ranges::find(test.answers, answers[k]) - test.answers.begin();
    ++test.count[k % hidden.size()][column];
  }
  int right = 0;
  for (std::size_t h = 1; h < hidden.size(); ++h) {
    const auto column = std::ranges::find(test.answers, test.hidden[h]) - test.answers.begin();
    right += test.count[h][column];
  }
  test.false_alarm_rate = 1.0 - static_cast<double>(test.count[0][0]) / options.self_tests;
  test.power = hidden.size() > 1 ? static_cast<double>(right) /
                                       static_cast<double>(runs - static_cast<std::size_t>(options.self_tests))
                                 : 0.0;
  return test;
}

}  // namespace simgap
