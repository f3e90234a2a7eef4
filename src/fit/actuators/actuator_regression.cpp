#include "simgap/fit/actuators/actuator_regression.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/model/friction/friction_evaluation.h"
#include "simgap/optimize/separable.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Kind = EffectParameter::Kind;

/// The unit a catalogue entry means on this drive: "Nm" is the load's, "A" the effort's.
std::string unitOn(std::string_view unit, const ActuatorData& data) {
  std::string text(unit);
  const auto replace = [&](std::string_view from, const std::string& to) {
    if (const auto at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
  };
  if (data.load_unit == "N") {
    replace("Nm", "N");
    replace("rad", "m");
  }
  if (data.effort_unit != "A") replace("A", data.effort_unit);
  return text;
}

/// The slowest Stribeck velocity that rows can tell: of a steeper curve too few of them would see anything but its end,
/// and what those few ask for is a static friction without bound.
double slowestSeen(const ActuatorData& data) {
  constexpr std::size_t kFewest = 20;  // rows
  std::vector<double> speeds;
  for (Index i = 0; i < data.rows.rows(); ++i) {
    if (data.keep[i]) speeds.push_back(std::abs(data.rows.speed[i]));
  }
  if (speeds.size() <= kFewest) return 0.0;
  std::ranges::nth_element(speeds, speeds.begin() + kFewest);
  return speeds[kFewest];
}

}  // namespace

ActuatorRegression::ActuatorRegression(const ActuatorBase& base, std::vector<const ActuatorEffect*> effects,
                                       const ActuatorData& data, std::optional<double> presliding)
    : base_(base), effects_(std::move(effects)), data_(&data), presliding_(presliding.has_value()) {
  const auto addLinear = [&](std::string name, std::string unit, double lower, double upper, bool times_gain) {
    add(std::move(name), std::move(unit), lower, upper);
    times_gain_.push_back(times_gain);
  };
  if (base.law != nullptr) {
    // Without a load there is no k_a: torques are then told in what the motor draws.
    const bool loaded = (data.rows.load != 0.0).any();
    addLinear("k_a", gainUnit(data.load_unit, data.effort_unit), loaded ? 1e-12 : 1.0, loaded ? kInfinity : 1.0, false);
    for (const ParameterSpec& p : termParameters(*base.law, data.load_unit))
      addLinear(p.name, p.unit, p.lower, p.upper, true);
    const auto viscous = std::ranges::find(base.law->terms, FrictionBasis::kVelocity, &FrictionTerm::basis);
    if (viscous != base.law->terms.end()) viscous_ = 1 + static_cast<std::size_t>(viscous - base.law->terms.begin());
  } else {
    for (const EffectColumn& column : base.equation->columns)
      addLinear(std::string(column.name), unitOn(column.unit, data), column.lower, column.upper, false);
  }
  for (const ParameterSpec& p : data.rig_parameters) addLinear(p.name, p.unit, 0.0, kInfinity, true);
  if (data.offset) addLinear("offset", data.effort_unit, -kInfinity, kInfinity, false);
  for (const ActuatorEffect* effect : effects_) {
    column_begin_.push_back(parameters_.size());
    for (const EffectColumn& column : effect->columns) {
      addLinear(fmt::format("{}.{}", effect->name, column.name), unitOn(column.unit, data), column.lower, column.upper,
                column.torque);
    }
  }
  linear_ = parameters_.size();
  if (base.law != nullptr) {
    std::ranges::copy(stribeckParameters(*base.law, data.rows.top_speed, data.velocity_unit),
                      std::back_inserter(parameters_));
    if (base.hasStribeck()) parameters_[linear_].lower = std::max(parameters_[linear_].lower, slowestSeen(data));
  }
  if (presliding) add(std::string(kNuisance), "rad", 1e-6, *presliding);
  if (data.angle) add(std::string(kAngleOffset), "rad", -kInfinity, kInfinity);
  for (const ActuatorEffect* effect : effects_) {
    p_begin_.push_back(parameters_.size());
    for (const EffectParameter& p : effect->parameters) {
      add(fmt::format("{}.{}", effect->name, p.name), unitOn(p.unit, data), p.lower, p.upper,
          p.kind == Kind::kScanned || p.kind == Kind::kConstant);
    }
  }
  implicit_ = std::ranges::any_of(effects_, [](const ActuatorEffect* effect) { return effect->implicit; });
  setRows(data);
}

void ActuatorRegression::setRows(const ActuatorData& data) {
  data_ = &data;
  log_speed_ = data.rows.speed.abs().max(1e-12).log();
  const std::vector<int>& session = data.rows.session;
  const auto n = static_cast<std::size_t>(data.rows.rows());
  session_begin_.resize(n);
  session_end_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    session_begin_[i] = i > 0 && session[i] == session[i - 1] ? session_begin_[i - 1] : static_cast<Index>(i);
  }
  for (std::size_t i = n; i-- > 0;) {
    session_end_[i] = i + 1 < n && session[i] == session[i + 1] ? session_end_[i + 1] : static_cast<Index>(i + 1);
  }
}

ActuatorRegression ActuatorRegression::on(const ActuatorData& rows) const {
  ActuatorRegression other = *this;
  other.setRows(rows);
  if (presliding_) other.parameters_[afterStribeck()].fixed = true;
  return other;
}

void ActuatorRegression::add(std::string name, std::string unit, double lower, double upper, bool fixed) {
  parameters_.push_back({std::move(name), std::move(unit), lower, upper, fixed});
}

ActuatorRegression::Terms ActuatorRegression::lawTerms(std::span<const double> p, const ArrayXd* stribeck) const {
  const ActuatorRows& rows = data_->rows;
  Terms t;
  t.shared.load = rows.load;
  t.shared.dry = rows.direction;
  t.shared.viscous = rows.speed;
  std::size_t at = 0;
  if (base_.hasStribeck()) {
    t.stribeck = stribeck != nullptr ? *stribeck : stribeckFactor(log_speed_, p[0], p[1]).value;
    at = 2;
  } else {
    t.stribeck = ArrayXd::Zero(rows.rows());
  }
  if (presliding_) actuator_effects::inEveryDrive().apply(p.subspan(at++, 1), rows, t.shared);
  if (data_->angle) {
    t.weight = data_->angle->load(p[at++]);
    if (!data_->angle->scaled) t.shared.load += t.weight - data_->angle->load(data_->angle->start);
  }
  return t;
}

ActuatorRegression::Terms ActuatorRegression::withEffects(Terms t, std::span<const double> p, const ArrayXd& effort,
                                                          std::vector<ActuatorTerms>* before) const {
  const ActuatorRows& rows = data_->rows;
  if (rows.pressure.size() > 0) {
    t.shared.effort = effort;
    t.shared.pressure = rows.pressure;
    t.shared.contraction = rows.contraction;
  }
  if (rows.deflection.size() > 0) t.shared.deflection = rows.deflection;
  applyFrom(0, p, t.shared, before);
  return t;
}

void ActuatorRegression::applyFrom(std::size_t first, std::span<const double> p, ActuatorTerms& terms,
                                   std::vector<ActuatorTerms>* before) const {
  if (before != nullptr) before->resize(effects_.size());
  for (std::size_t e = first; e < effects_.size(); ++e) {
    if (effects_[e]->apply == nullptr) continue;
    if (before != nullptr) (*before)[e] = terms;
    effects_[e]->apply(own(e, p), data_->rows, terms);
  }
}

ActuatorRegression::Fills ActuatorRegression::fills(const Terms& t, std::span<const double> p, Fills known) const {
  known.resize(effects_.size());
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const auto count = static_cast<Index>(effects_[e]->columns.size());
    if (count == 0 || known[e] != nullptr) continue;
    const auto added = std::make_shared<Eigen::ArrayXXd>(rows(), count);
    effects_[e]->fill(own(e, p), data_->rows, t.shared, t.stribeck, *added);
    known[e] = added;
  }
  return known;
}

template <typename Visit>
void ActuatorRegression::visitColumns(const Terms& t, const Fills& fills, const Visit& visit) const {
  const ActuatorTerms& terms = t.shared;
  const bool gain = terms.gain.size() > 0;
  std::size_t j = 0;
  const auto give = [&](const auto& column) {
    if (gain && (j == 0 || times_gain_[j])) {
      visit(j, column / terms.gain);
    } else {
      visit(j, column);
    }
    ++j;
  };
  if (base_.law != nullptr) {
    give(terms.load);
    for (const FrictionTerm& term : base_.law->terms) {
      visitBasis(term.basis, terms.load.abs(), terms.dry, terms.viscous,
                 [&](const auto& column) { visitShape(term.shape, column, t.stribeck, give); });
    }
  } else {
    Eigen::ArrayXXd x(rows(), static_cast<Index>(base_.equation->columns.size()));
    base_.equation->fill(data_->rows, terms, x);
    for (Index k = 0; k < x.cols(); ++k) give(x.col(k));
  }
  for (Index k = 0; k < data_->rig.cols(); ++k) {
    if (k == 0 && data_->angle && data_->angle->scaled) {
      give(t.weight);
    } else {
      give(data_->rig.col(k));
    }
  }
  if (data_->offset) give(ArrayXd::Ones(rows()));
  for (const auto& added : fills) {
    if (added == nullptr) continue;
    for (Index k = 0; k < added->cols(); ++k) give(added->col(k));
  }
}

ActuatorRegression::Shift ActuatorRegression::shift(double delay) const {
  const double shift = delay / data_->rows.step;
  const double whole = std::floor(shift);
  return {static_cast<Index>(whole), shift - whole};
}

template <typename Array>
void ActuatorRegression::delayRows(Array& array, double delay) const {
  if (delay == 0.0) return;
  // effort(t) = P(t - delay): between the two rows before that moment, within the session.
  const Shift by = shift(delay);
  const Array original = array;
  for (Index i = 0; i < rows(); ++i) {
    array.row(i) =
        (1.0 - by.part) * original.row(source(i, by.whole)) + by.part * original.row(source(i, by.whole + 1));
  }
}

Eigen::Index ActuatorRegression::source(Index row, Index by) const {
  const auto k = static_cast<std::size_t>(row);
  return std::clamp(row - by, session_begin_[k], session_end_[k] - 1);
}

void ActuatorRegression::blank(Eigen::Ref<Eigen::MatrixXd> matrix, const std::vector<bool>& keep) {
  for (Index i = 0; i < matrix.rows(); ++i) {
    if (!keep[static_cast<std::size_t>(i)]) matrix.row(i).setZero();
  }
}

std::vector<bool> ActuatorRegression::counted(double delay) const {
  if (delay == 0.0) return data_->keep;
  const auto by = static_cast<Index>(std::lround(delay / data_->rows.step));
  std::vector<bool> keep(data_->keep.size());
  for (Index i = 0; i < rows(); ++i) {
    keep[i] = data_->keep[source(i, by)] && (data_->effort_lost.empty() || !data_->effort_lost[i]);
  }
  return keep;
}

ActuatorRegression::Evaluation ActuatorRegression::columns(Terms law, std::span<const double> p,
                                                           bool slopes_too) const {
  Evaluation result;
  result.x.resize(rows(), static_cast<Index>(linear_));
  result.terms = withEffects(std::move(law), p, data_->rows.effort, slopes_too ? &result.before : nullptr);
  result.fills = fills(result.terms, p);
  visitColumns(result.terms, result.fills, [&](std::size_t j, const auto& column) { result.x.col(j) = column; });
  delayRows(result.x, result.terms.shared.delay);
  return result;
}

Eigen::ArrayXd ActuatorRegression::predict(std::span<const double> theta) const {
  double delay = 0.0;
  return predict(lawTerms(theta.subspan(linear_)), theta, delay);
}

double ActuatorRegression::delay(std::span<const double> theta) const {
  const std::span<const double> p = theta.subspan(linear_);
  return withEffects(lawTerms(p), p, data_->rows.effort).shared.delay;
}

bool ActuatorRegression::isDelay(std::span<const double> theta, std::size_t parameter) const {
  const double whole = parameter < linear_ ? 0.0 : delay(theta);
  if (whole == 0.0) return false;
  std::vector<double> without(theta.begin(), theta.end());
  without[parameter] = 0.0;
  return delay(without) != whole;
}

ArrayXd ActuatorRegression::predict(const Terms& law, std::span<const double> theta, double& delay) const {
  const std::span<const double> p = theta.subspan(linear_);
  const auto rightHandSideAt = [&](const ArrayXd& effort) {
    const Terms t = withEffects(law, p, effort);
    delay = t.shared.delay;
    return rightHandSide(t, fills(t, p), theta);
  };
  ArrayXd effort = rightHandSideAt(data_->rows.effort);
  if (!implicit_) return effort;
  // f = F(f) from the measured f, row by row as Steffensen (1933) does it, so that its noise is not in the prediction.
  constexpr int kRounds = 3;
  ArrayXd start = data_->rows.effort;
  for (int round = 0; round < kRounds; ++round) {
    const ArrayXd again = rightHandSideAt(effort);
    const ArrayXd step = effort - start, slope = (again - effort) / (step.abs() > 1e-12).select(step, 1.0);
    start = (slope < 0.9).select(start + step / (1.0 - slope), again);
    effort = rightHandSideAt(start);
  }
  return effort;
}

ArrayXd ActuatorRegression::rightHandSide(const Terms& t, const Fills& fills, std::span<const double> theta) const {
  ArrayXd sum = ArrayXd::Zero(rows()), for_speed;
  visitColumns(t, fills, [&](std::size_t j, const auto& column) {
    sum += theta[j] * column;
    if (j == viscous_ && t.shared.saturation.acts()) for_speed = theta[j] * column;
  });
  delayRows(sum, t.shared.delay);
  if (!t.shared.saturation.acts()) return sum;
  delayRows(for_speed, t.shared.delay);
  return t.shared.saturation.effort(sum, for_speed);
}

std::vector<double> ActuatorRegression::startFrom(const ActuatorRegression& other,
                                                  std::span<const double> theta) const {
  std::vector<double> start(parameters_.size(), 0.0);
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    for (std::size_t k = 0; k < effects_[e]->parameters.size(); ++k) {
      start[p_begin_[e] + k] = effects_[e]->parameters[k].start;
    }
  }
  const std::size_t own = afterStribeck();
  if (presliding_) start[own] = 1e-3;
  if (data_->angle) start[own + (presliding_ ? 1 : 0)] = data_->angle->start;
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const auto found = std::ranges::find(other.parameters_, parameters_[i].name, &ParameterSpec::name);
    if (found != other.parameters_.end()) start[i] = theta[found - other.parameters_.begin()];
  }
  return start;
}

std::vector<double> ActuatorRegression::solveCoefficients(std::vector<double> theta, std::span<const Block> blocks,
                                                          double* cost) const {
  const std::span<const double> p = std::span<const double>(theta).subspan(linear_);
  Evaluation e = columns(lawTerms(p), p);
  const auto c = static_cast<Index>(linear_);
  Eigen::VectorXd effort = data_->rows.effort.matrix();
  const std::vector<bool> keep = counted(e.terms.shared.delay);
  blank(e.x, keep);
  blank(effort, keep);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(c + 1, c + 1);
  for (const Block& b : blocks) {
    const auto begin = static_cast<Index>(b.begin), size = static_cast<Index>(b.size());
    const auto x = e.x.middleRows(begin, size);
    const auto y = effort.segment(begin, size);
    gram.topLeftCorner(c, c).selfadjointView<Eigen::Lower>().rankUpdate(x.transpose());
    gram.row(c).head(c).noalias() += y.transpose() * x;
    gram(c, c) += y.squaredNorm();
  }
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  std::vector<LinearTerm> terms;
  for (std::size_t i = 0; i < linear_; ++i) {
    terms.push_back({parameters_[i].name, parameters_[i].lower, parameters_[i].upper, times_gain_[i]});
  }
  const LinearSolution solution = solveBounded(gram, terms);
  std::copy(solution.coefficients.begin(), solution.coefficients.end(), theta.begin());
  if (cost != nullptr) *cost = solution.cost;
  return theta;
}

}  // namespace simgap
