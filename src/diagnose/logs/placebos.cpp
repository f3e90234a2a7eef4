#include "placebos.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/surrogates.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/ranks.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Rows of the training blocks that count, in their order.
std::vector<Index> countedRows(const LogSearch& search, const VectorXd& residual) {
  std::vector<Index> rows;
  for (const Block& b : search.training()) {
    for (std::size_t k = b.begin; k < b.end; ++k) {
      if (residual[k] != 0.0) rows.push_back(static_cast<Index>(k));
    }
  }
  return rows;
}

/// What the model's other parameters have learnt: projections on their columns B by the normal matrix B^T B.
struct Others {
  MatrixXd columns;              ///< B, shape (n, P), each of length 1: units must not decide which the ridge takes
  Eigen::LDLT<MatrixXd> normal;  ///< of B^T B, a touch of ridge for columns that say what others say
  VectorXd residual;             ///< r, shape (n)
  VectorXd onto;                 ///< (B^T B)^-1 B^T r

  explicit Others(MatrixXd b, VectorXd r) : columns(std::move(b)), residual(std::move(r)) {
    columns.colwise().normalize();
    MatrixXd gram = columns.transpose() * columns;
    gram.diagonal().array() += 1e-9;
    normal.compute(gram);
    onto = normal.solve(columns.transpose() * residual);
  }

  /// Share of r^T r that the columns `own` explain beyond B: with O' = O - B (B^T B)^-1 B^T O and g = O'^T r,
  /// g^T (O'^T O')^-1 g / r^T r.
  double gain(MatrixXd own) const {
    own.colwise().normalize();
    const MatrixXd cross = columns.transpose() * own;
    MatrixXd gram = own.transpose() * own - cross.transpose() * normal.solve(cross);
    const VectorXd g = own.transpose() * residual - cross.transpose() * onto;
    gram.diagonal().array() += 1e-12;
    return g.dot(gram.ldlt().solve(g)) / std::max(residual.squaredNorm(), 1e-300);
  }
};

/// An offset has no colour that a placebo could have.
bool isConstant(const MatrixXd& signature) {
  const MatrixXd centred = signature.rowwise() - signature.colwise().mean();
  return centred.squaredNorm() < 1e-6 * signature.squaredNorm();
}

/// A cause without a size, such as a cord that hangs loose below some length: there is no small amount of it, so that
/// only what it changes as a whole is its signature, and not the derivatives where it is.
bool isAllShape(const ActuatorEffect& effect) {
  const auto is_shape = [](const EffectParameter& p) { return p.kind == EffectParameter::Kind::kShape; };
  return effect.columns.empty() && std::ranges::all_of(effect.parameters, is_shape);
}

/// Of how much of an effect there is, all of it is its signature: the slope where it ended says little of what it
/// changes from none on, as with a delay of several rows or with play, whose slope lives where the teeth meet.
void takeWholeChanges(const Fitted& full, const VectorXd& residual, std::size_t effect, MatrixXd& jacobian) {
  const auto& parameters = full.model->effects()[effect]->parameters;
  const std::size_t first = full.model->firstParameter(effect);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (parameters[k].kind != EffectParameter::Kind::kSmooth) continue;
    std::vector<double> theta = full.theta;
    theta[first + k] = parameters[k].neutral;
    const Eigen::ArrayXd without = residualOf(full, theta).array();
    const VectorXd change = (without != 0.0).select(without - residual.array(), 0.0);
    if (change.squaredNorm() > 0.0) jacobian.col(static_cast<Index>(first + k)) = change;
  }
}

constexpr double kNeighbours = 5.0;  ///< times the delay: rows whose errors are averaged, at least as many rows
/// Of what single rows gain. A delay's errors are pulses as long as itself, of which means over five times that keep a
/// fifth, or 0.19 as some of them are cut by the ends of a mean; noise that is read at another row keeps nothing.
/// Shares of the whole error would not tell: what else the model lacks is slow, and no delay's fault.
constexpr double kHolds = 0.1;
constexpr double kOpposite = 0.5;

/// Squared errors of two models on the rows that both count: of single rows, and of means over neighbours.
struct CommonErrors {
  double before = 0.0, after = 0.0, slow_before = 0.0, slow_after = 0.0;

  double gain() const { return 1.0 - after / std::max(before, 1e-300); }
  /// Of what single rows gain, the share that is left of means.
  double held() const { return (slow_before - slow_after) / std::max(before - after, 1e-300); }
};

/// \param window  rows that are averaged; of what is left at the end of a run half of them is enough.
CommonErrors compare(const LogSearch& search, const VectorXd& before, const VectorXd& after, int window) {
  CommonErrors errors;
  int together = 0;
  double sum_before = 0.0, sum_after = 0.0;
  const auto average = [&] {
    if (2 * together >= window) {
      errors.slow_before += sum_before * sum_before / together;
      errors.slow_after += sum_after * sum_after / together;
    }
    together = 0, sum_before = 0.0, sum_after = 0.0;
  };
  for (const Block& block : search.training()) {
    for (std::size_t k = block.begin; k < block.end; ++k) {
      const double b = before[k], a = after[k];
      if (b == 0.0 || a == 0.0) {
        average();
        continue;
      }
      errors.before += b * b, errors.after += a * a;
      sum_before += b, sum_after += a;
      if (++together == window) average();
    }
    average();
  }
  return errors;
}

/// The parameters with the effect's own times a factor.
std::vector<double> scaled(const Fitted& full, std::size_t effect, double factor) {
  std::vector<double> theta = full.theta;
  const std::size_t first = full.model->firstParameter(effect);
  for (std::size_t k = 0; k < full.model->effects()[effect]->parameters.size(); ++k) theta[first + k] *= factor;
  return theta;
}

/// The delays that explain best the rows of either direction of motion, forwards and backwards, of a law that is fitted
/// to both [s].
std::array<double, 2> delaysByDirection(const LogSearch& search, const Fitted& full, std::size_t effect) {
  constexpr int kSteps = 16;  // from no delay to twice the fitted one
  const Eigen::ArrayXd& direction = search.data().rows.direction;
  std::array<std::vector<double>, 2> errors;
  for (int k = 0; k <= kSteps; ++k) {
    // The law follows each delay: one that was fitted to a mean of two would favour that mean.
    const std::vector<double> moved = scaled(full, effect, 2.0 * k / kSteps);
    const VectorXd residual = residualOf(full, full.model->solveCoefficients(moved, search.training()));
    double sum[2] = {0.0, 0.0}, rows[2] = {0.0, 0.0};
    for (const Index i : countedRows(search, residual)) {
      const int side = direction[i] > 0.0 ? 0 : 1;
      sum[side] += residual[i] * residual[i];
      rows[side] += 1.0;
    }
    for (const std::size_t side : {0u, 1u}) errors[side].push_back(sum[side] / std::max(rows[side], 1.0));
  }
  std::array<double, 2> best{};
  for (const std::size_t side : {0u, 1u}) {
    const auto at = std::ranges::min_element(errors[side]) - errors[side].begin();
    best[side] = full.model->delay(full.theta) * 2.0 * static_cast<double>(at) / kSteps;
  }
  return best;
}

/// Why what differs by direction is no delay: a channel that is late is late by one time.
std::string doubtOfOneTime(const LogSearch& search, const Fitted& full, std::size_t effect) {
  constexpr double kApart = 0.5;        // of their mean: what was fitted to both leans to the side that moves less
  constexpr double kResolution = 0.75;  // of the time from row to row
  const auto [forwards, backwards] = delaysByDirection(search, full, effect);
  const double apart = std::abs(forwards - backwards), mean = 0.5 * (std::abs(forwards) + std::abs(backwards));
  if (apart <= std::max(kApart * mean, kResolution * search.step())) return {};
  return fmt::format(
      "forwards {:.0f} ms explain most and backwards {:.0f} ms: a channel that is late is so by one time",
      1e3 * forwards, 1e3 * backwards);
}

}  // namespace

PlaceboTest testPlacebos(const LogSearch& search, const Fitted& full, const Fitted& rest, std::size_t effect,
                         std::uint64_t seed) {
  VectorXd residual, own_residual;
  MatrixXd jacobian, rest_jacobian;
  rest.model->evaluate(rest.theta, residual, &rest_jacobian);
  full.model->evaluate(full.theta, own_residual, &jacobian);
  takeWholeChanges(full, own_residual, effect, jacobian);
  const std::vector<Index> rows = countedRows(search, own_residual);
  const ActuatorRegression& model = *full.model;
  std::vector<Index> own, others;
  const auto addOwn = [&](std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) {
      if (jacobian.col(i).squaredNorm() > 0.0) own.push_back(static_cast<Index>(i));
    }
  };
  addOwn(model.firstColumn(effect), model.effects()[effect]->columns.size());
  addOwn(model.firstParameter(effect), model.effects()[effect]->parameters.size());
  for (std::size_t i = 0; i < rest.theta.size(); ++i) {
    const ParameterSpec& p = rest.model->parameters()[i];
    const bool free = !p.fixed && p.upper > p.lower;
    if (free && rest_jacobian.col(i).squaredNorm() > 0.0) others.push_back(static_cast<Index>(i));
  }
  PlaceboTest test;
  if (own.empty() || rows.size() < 100) return test;
  const Others fitted(MatrixXd(rest_jacobian(rows, others)), VectorXd(residual(rows)));
  MatrixXd signature = jacobian(rows, own);
  if (isAllShape(*model.effects()[effect])) {
    signature.conservativeResize(Eigen::NoChange, signature.cols() + 1);
    signature.rightCols(1) = own_residual(rows) - residual(rows);
  }
  if (isConstant(signature)) return {0.0, 0.0, 0.0};
  test.gain = fitted.gain(signature);
  std::vector<double> gains(kPlacebos);
  const auto gainOf = [&](std::size_t draw) {
    stopIfInterrupted();
    MatrixXd placebo(signature.rows(), signature.cols());
    for (Index k = 0; k < signature.cols(); ++k) {
      placebo.col(k) = phaseRandomised(signature.col(k), static_cast<std::uint32_t>(draw), seed);
    }
    return fitted.gain(placebo);
  };
  Bytes digest;
  pack(digest, full.theta);
  computeOnRanks(std::span(gains), gainOf, /*one_by_one=*/false, std::move(digest));
  test.largest = *std::ranges::max_element(gains);
  test.p = placeboP(test.gain, gains);
  return test;
}

std::string doubtOfDelay(const LogSearch& search, const Fitted& full, const Fitted& rest, std::size_t effect) {
  const std::vector<double> opposite = scaled(full, effect, -1.0);
  const double delay = full.model->delay(full.theta);
  if (delay == full.model->delay(opposite)) return {};
  const double rows_late = std::abs(delay) / search.step();
  const int window = static_cast<int>(std::ceil(kNeighbours * std::max(1.0, rows_late)));
  const VectorXd before = residualOf(rest);
  const CommonErrors errors = compare(search, before, residualOf(full), window);
  if (errors.held() < kHolds) {
    return fmt::format(
        "of what it explains of single rows means over {} of them keep {:.0f} %, of a delay's 19 %: noise that a "
        "controller feeds back looks like that",
        window, 100.0 * std::max(0.0, errors.held()));
  }
  const VectorXd turned = residualOf(full, full.model->solveCoefficients(opposite, search.training()));
  const double other = compare(search, before, turned, window).gain();
  if (other <= kOpposite * errors.gain()) return doubtOfOneTime(search, full, effect);
  return fmt::format("the opposite delay explains {:.1f} %, too (this one {:.1f} %)", 100.0 * other,
                     100.0 * errors.gain());
}

}  // namespace simgap
