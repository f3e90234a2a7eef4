#include "log_prediction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/fit/actuators/actuator_regression.h"
#include "simgap/fit/actuators/prediction.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr EffectParameter kGainParameter[] = {{"factor", "1", 1e-3, 1e3, 1.0, 1.0, EffectParameter::Kind::kConstant}};

void applyGain(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  if (terms.gain.size() == 0) terms.gain = ArrayXd::Ones(rows.rows());
  terms.gain *= p[0];
}

/// Not a cause: another amplifier or supply, known from the change.
const ActuatorEffect kKnownGain{.name = "known-gain",
                                .cause = "",
                                .equation = "",
                                .signature = "",
                                .source = "",
                                .look_alikes = "",
                                .separates = "",
                                .parameters = kGainParameter,
                                .apply = applyGain};

/// L of L L^T = covariance, which may be singular. Parameters have units of any size: their scale is taken out first.
MatrixXd factorOf(const MatrixXd& covariance) {
  const VectorXd sd = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const VectorXd scale = (sd.array() > 0.0).select(sd.cwiseInverse(), 0.0);
  const SymmetricEigen eigen = symmetricEigen(scale.asDiagonal() * covariance * scale.asDiagonal());
  return sd.asDiagonal() * eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// A candidate's equation on a changed log.
class Asking {
 public:
  Asking(const LogEvidence::Candidate& candidate, const ChangedLog& changed)
      : changed_(changed), subject_(subjectOf(candidate.model)) {
    const bool other_gain = changed.setting.strength != 1.0;
    const std::size_t own = subject_.effects.size();
    if (other_gain) {
      subject_.effects.push_back(&kKnownGain);
      subject_.values.push_back({"known-gain.factor", "1", changed.setting.strength});
    }
    const auto presliding = std::ranges::find(subject_.values, kNuisance, &Estimate::name);
    std::optional<double> largest;
    if (presliding != subject_.values.end()) largest = presliding->value;
    regression_ = std::make_unique<ActuatorRegression>(subject_.base, subject_.effects, changed.log.data, largest);
    theta_ = regression_->thetaOf(subject_.values);
    known_.assign(theta_.size(), false);
    for (std::size_t e = 0; e < own; ++e) {
      if (std::ranges::find(changed.setting.undone, subject_.effects[e]->name) != changed.setting.undone.end()) undo(e);
    }
    const std::vector<ParameterSpec>& names = regression_->parameters();
    const auto angle = changed.setting.added.find("angle_offset");
    for (std::size_t i = 0; i < names.size() && angle != changed.setting.added.end(); ++i) {
      if (names[i].name == kAngleOffset) theta_[i] += angle->second;
    }
  }

  ArrayXd predict() const {
    ArrayXd values = regression_->predict(theta_);
    if (changed_.setting.resistance != 0.0) values += changed_.setting.resistance * changed_.log.data.rows.current;
    return values(changed_.rows);
  }

  /// J L, shape (rows, P).
  MatrixXd spread(const LogPosterior& posterior) const {
    VectorXd residual;
    MatrixXd jacobian;
    regression_->evaluate(theta_, residual, &jacobian);
    const MatrixXd factor = factorOf(posterior.covariance);
    MatrixXd own = MatrixXd::Zero(jacobian.cols(), factor.cols());
    for (Index i = 0; i < own.rows(); ++i) {
      const auto at = std::ranges::find(posterior.names, regression_->parameters()[i].name);
      if (at != posterior.names.end() && !known_[i]) own.row(i) = factor.row(at - posterior.names.begin());
    }
    return jacobian(changed_.rows, Eigen::all) * own;
  }

 private:
  /// What the change has taken away is known to be nothing.
  void undo(std::size_t effect) {
    const ActuatorEffect& cause = *subject_.effects[effect];
    for (std::size_t k = 0; k < cause.columns.size(); ++k) forget(regression_->firstColumn(effect) + k, 0.0);
    for (std::size_t k = 0; k < cause.parameters.size(); ++k) {
      if (cause.parameters[k].kind != EffectParameter::Kind::kSmooth) continue;
      forget(regression_->firstParameter(effect) + k, cause.parameters[k].neutral);
    }
  }
  void forget(std::size_t parameter, double value) {
    theta_[parameter] = value;
    known_[parameter] = true;
  }

  const ChangedLog& changed_;
  ActuatorModel subject_;
  std::unique_ptr<ActuatorRegression> regression_;
  std::vector<double> theta_;
  std::vector<bool> known_;
};

/// \param recorded  see LogChanges::apply
LogSetting settingOf(const LogEvidence& evidence, const LogChanges& change, bool recorded) {
  LogSetting setting;
  setting.kind = subjectOf(evidence.candidates.front().model).base.kind;
  setting.bench = evidence.bench;
  change.apply(setting, recorded);
  return setting;
}

/// What was added to constants that the bench lets be fitted, and the gear, which divides every load at the motor.
void changeLoads(ChangedLog& changed) {
  ActuatorData& data = changed.log.data;
  for (std::size_t k = 0; k < data.rig_parameters.size(); ++k) {
    const auto added = changed.setting.added.find(
        data.rig_parameters[k].name == "total_inertia" ? "inertia" : data.rig_parameters[k].name);
    if (added != changed.setting.added.end()) data.rows.load += added->second * data.rig.col(k);
  }
  const double gear = changed.setting.gear;
  if (gear == 1.0) return;
  data.rows.load /= gear;
  data.rig /= gear;
  if (data.angle) {
    data.angle->sine /= gear;
    data.angle->cosine /= gear;
  }
}

}  // namespace

CsvTable profileOf(const LogEvidence& evidence, const LogChanges& change) {
  const LogSetting setting = settingOf(evidence, change, /*recorded=*/false);
  const CsvTable plain = CsvTable::parse(evidence.reference, evidence.reference_file);
  CsvOptions options;
  for (const auto& [channel, factor] : setting.channels) {
    for (const std::string& column : plain.columns()) {
      if (splitUnit(column).stem != channel) continue;
      options.rename[column] = column;
      options.scale[column] = factor;
    }
  }
  return options.scale.empty() ? plain : CsvTable::parse(evidence.reference, evidence.reference_file, options);
}

ChangedLog changedLog(const LogEvidence& evidence, const LogChanges& change, const CsvTable& table, bool recorded) {
  const FittedModel& model = evidence.candidates.front().model;
  ChangedLog changed;
  changed.setting = settingOf(evidence, change, recorded);
  Bench& bench = changed.setting.bench;
  if (bench.ratio) *bench.ratio *= changed.setting.gear;
  changed.log = prepareLog(table, bench, changed.setting.kind, dataOptionsOf(model));
  ActuatorRows& rows = changed.log.data.rows;
  if (changed.setting.warmer != 0.0) {
    if (rows.temperature.size() == 0) {
      throw DataError(
          fmt::format("{}:1: found no temperature_degC, expected it to foresee what warmth does", table.name()));
    }
    rows.temperature += changed.setting.warmer;
  }
  const std::string unit = model.setting("effort", changed.log.data.effort_unit);
  if (changed.log.data.effort_unit != unit) {
    throw DataError(fmt::format("{}:1: found an effort in {}, expected {} as in the log that was diagnosed",
                                table.name(), changed.log.data.effort_unit, unit));
  }
  changeLoads(changed);
  for (std::size_t i = 0; i < changed.log.data.keep.size(); ++i) {
    if (changed.log.data.keep[i]) changed.rows.push_back(static_cast<Index>(i));
  }
  if (changed.rows.empty()) throw DataError(table.name() + ": found no row that means something to these models");
  return changed;
}

std::string nextLogCsv(const LogEvidence& evidence, const LogChanges& change) {
  const CsvTable profile = profileOf(evidence, change);
  return logCsv(profile, splitUnit(changedLog(evidence, change, profile, /*recorded=*/false).log.effort_column).stem);
}

PredictedRows predictRows(const LogEvidence::Candidate& candidate, const ChangedLog& changed,
                          const std::vector<std::pair<ChangedLog, ChangedLog>>& moved) {
  const Asking asking(candidate, changed);
  PredictedRows result;
  result.values = asking.predict();
  const MatrixXd own = asking.spread(candidate.known.posterior);
  result.spread.resize(own.rows(), own.cols() + std::ssize(moved));
  result.spread.leftCols(own.cols()) = own;
  for (Index k = 0; k < std::ssize(moved); ++k) {
    const auto& [forward, back] = moved[k];
    result.spread.col(own.cols() + k) =
        0.5 * (Asking(candidate, forward).predict() - Asking(candidate, back).predict()).matrix();
  }
  return result;
}

Distance distanceOf(const VectorXd& e, const MatrixXd& a, double tau) {
  const SymmetricEigen eigen = symmetricEigen(a.transpose() * a / tau);
  const VectorXd b = eigen.vectors.transpose() * (a.transpose() * e / tau);
  const double negligible = 1e-12 * std::max(1.0, eigen.values.cwiseAbs().maxCoeff());
  Distance distance;
  VectorXd x = VectorXd::Zero(b.size());
  double explained = 0.0;
  for (Index i = 0; i < b.size(); ++i) {
    const double size = eigen.values[i];
    if (size <= negligible) continue;
    const double component = b[i] * b[i] / size;  // of e along A v_i
    explained += component;
    distance.along += component / (1.0 + size);
    distance.log_volume += std::log1p(size);
    x[i] = b[i] / (1.0 + size);
    ++distance.directions;
  }
  distance.beside = std::max(0.0, e.squaredNorm() / tau - explained);
  distance.left = e - a * (eigen.vectors * x);
  return distance;
}

}  // namespace simgap
