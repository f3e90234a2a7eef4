#include "trial_tests.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::Index;

/// How alike two causes change the residual of a model that has neither, over the rows that all count: their
/// correlation, -1 to 1.
double likeness(const Fitted& base, const Fitted& one, const Fitted& other) {
  const Eigen::ArrayXd without = residualOf(base).array(), a = residualOf(one).array(), b = residualOf(other).array();
  const Eigen::ArrayXd shared = (without != 0.0 && a != 0.0 && b != 0.0).cast<double>();
  const Eigen::ArrayXd by_one = shared * (a - without), by_other = shared * (b - without);
  return (by_one * by_other).sum() / std::max(std::sqrt(by_one.square().sum() * by_other.square().sum()), 1e-300);
}

}  // namespace

double distinctShare(const ActuatorRegression& model, const RowEvaluation& at, std::span<const Block> blocks,
                     std::size_t effect) {
  const Eigen::MatrixXd h = gramOf(at.jacobian, blocks);
  std::vector<Index> own, others;
  const std::size_t columns = model.firstColumn(effect), values = model.firstParameter(effect);
  for (Index i = 0; i < h.cols(); ++i) {
    if (h(i, i) <= 1e-300) continue;
    const auto k = static_cast<std::size_t>(i);
    const bool is_own = (k >= columns && k < columns + model.effects()[effect]->columns.size()) ||
                        (k >= values && k < values + model.effects()[effect]->parameters.size());
    (is_own ? own : others).push_back(i);
  }
  const Eigen::VectorXd scale = h.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = scale.asDiagonal() * h * scale.asDiagonal();
  Eigen::MatrixXd base = unit(others, others);
  base.diagonal().array() += 1e-10;
  const Eigen::LDLT<Eigen::MatrixXd> factor(base);
  double share = 0.0;
  for (const Index i : own) {
    const Eigen::VectorXd cross = unit.col(i)(others);
    share = std::max(share, 1.0 - cross.dot(factor.solve(cross)));
  }
  return share;
}

double waldP(const ActuatorRegression& model, const RowEvaluation& at, const std::vector<Block>& pieces) {
  constexpr double kSearched = 1000.0;
  constexpr std::size_t kPiecesPerParameter = 5;
  const std::vector<double>& theta = at.theta;
  if (pieces.size() < kPiecesPerParameter * theta.size()) return 1.0;
  const Eigen::MatrixXd covariance = blockCovariance(model, pieces, at);
  const std::size_t e = model.effects().size() - 1;
  const ActuatorEffect& effect = *model.effects()[e];
  double largest = 0.0;
  const auto look = [&](std::size_t i, double neutral) {
    const double variance = covariance(static_cast<Index>(i), static_cast<Index>(i));
    if (variance > 0.0) largest = std::max(largest, std::abs(theta[i] - neutral) / std::sqrt(variance));
  };
  for (std::size_t k = 0; k < effect.columns.size(); ++k) look(model.firstColumn(e) + k, 0.0);
  for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
    if (effect.parameters[k].kind == EffectParameter::Kind::kSmooth)
      look(model.firstParameter(e) + k, effect.parameters[k].neutral);
  }
  return std::min(1.0, kSearched * 2.0 * normalTail(largest));
}

bool saysTheSame(const Fitted& base, const Trial& winner, const Trial& other) {
  constexpr double kLaws = 0.1;   // of the gain
  constexpr double kAlike = 0.9;  // correlation
  const ActuatorEffect &one = *winner.hypothesis.effect, &two = *other.hypothesis.effect;
  return !one.kin.empty() && one.kin == two.kin && other.gain->value > (1.0 - kLaws) * winner.gain->value &&
         likeness(base, winner.fitted, other.fitted) > kAlike;
}

std::size_t sizesOf(const ActuatorEffect& effect) {
  const auto fitted = [](const EffectParameter& p) { return p.kind != EffectParameter::Kind::kConstant; };
  return effect.columns.size() + static_cast<std::size_t>(std::ranges::count_if(effect.parameters, fitted));
}

std::vector<const Trial*> oneOfEach(const std::vector<const Trial*>& trials, std::size_t most) {
  std::vector<const Trial*> few;
  for (const Trial* trial : trials) {
    const auto same = [&](const Trial* other) {
      return other->hypothesis.effect->name == trial->hypothesis.effect->name;
    };
    if (few.size() < most && std::ranges::none_of(few, same)) few.push_back(trial);
  }
  return few;
}

std::vector<std::string> aliased(const std::vector<Trial>& trials) {
  std::vector<std::string> names;
  for (const Trial& trial : trials) {
    const std::string name(trial.hypothesis.effect->name);
    const auto told = [&](const Trial& other) { return other.identifiable && other.hypothesis.effect->name == name; };
    const bool known = std::ranges::find(names, name) != names.end();
    if (!known && std::ranges::none_of(trials, told)) names.push_back(name);
  }
  return names;
}

}  // namespace simgap
