/// \file
/// Cogging, a gear or a screw: a force that repeats with the shaft angle, a sin(r theta) + b cos(r theta), or what
/// repeats with r with its second and third harmonic. The ratio r is searched on the spectrum of the residual over the
/// angle, then fitted.
#include "simgap/model/effects/actuator_effect.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/effects/spectral_peaks.h"

namespace simgap::actuator_effects::position_ripple {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kJointAngle};
constexpr EffectParameter kParameters[] = {{"r", "1", 0.5, 1e4, 1.0, 1.0, EffectParameter::Kind::kShape}};
constexpr EffectColumn kColumns[] = {{"a", "Nm"}, {"b", "Nm"}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  for (Eigen::Index i = 0; i < x.rows(); ++i) {  // both of an angle at once
    const double angle = p[0] * rows.joint_angle[i];
    x(i, 0) = std::sin(angle);
    x(i, 1) = std::cos(angle);
  }
}

constexpr EffectColumn kHarmonicColumns[] = {{"a", "Nm"},   {"b", "Nm"},   {"a_2", "Nm"},
                                             {"b_2", "Nm"}, {"a_3", "Nm"}, {"b_3", "Nm"}};

void fillHarmonics(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
                   const Eigen::ArrayXd& stribeck, Eigen::Ref<Eigen::ArrayXXd> x) {
  fill(p, rows, terms, stribeck, x.leftCols(2));
  for (Eigen::Index k = 2; k < 6; k += 2) {  // sin (k + 1) a = sin k a cos a + cos k a sin a, and so the cosine
    x.col(k) = x.col(k - 2) * x.col(1) + x.col(k - 1) * x.col(0);
    x.col(k + 1) = x.col(k - 1) * x.col(1) - x.col(k - 2) * x.col(0);
  }
}

bool counts(std::span<const double> p, const ActuatorRows& rows) { return repeats(p[0], rows.joint_angle); }

/// Power of the residual over the angle: rows are summed in narrow bins of the angle, then transformed directly.
std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& residual) {
  constexpr Eigen::Index kBins = 2048;
  const double low = rows.joint_angle.minCoeff(), span = rows.joint_angle.maxCoeff() - low;
  if (!(span > 0.0)) return {};
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(kBins), angle(kBins);
  for (Eigen::Index k = 0; k < kBins; ++k) angle[k] = (static_cast<double>(k) + 0.5) * span / kBins;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto bin = static_cast<Eigen::Index>((rows.joint_angle[i] - low) / span * kBins);
    sum[std::min(bin, kBins - 1)] += residual[i];
  }
  // From the fewest periods in the range on, to a third of the bins' Nyquist frequency.
  const double period = 2.0 * std::numbers::pi / span, lowest = kFewestPeriods * period,
               highest = kBins / 3.0 * std::numbers::pi / span;
  const auto power = [&](double r) {
    const double s = (sum * (r * angle).sin()).sum(), c = (sum * (r * angle).cos()).sum();
    return s * s + c * c;
  };
  std::vector<std::vector<double>> list;
  for (const double ratio : strongestPeaks(lowest, highest, 0.15 * period, 4, power)) list.push_back({ratio});
  return list;
}

constexpr ActuatorEffect kUsual = {
    .name = "position-ripple",
    .form = "sine",
    .cause = "a force that repeats with the shaft angle: cogging, a gear, a screw",
    .equation = "tau += a sin(r theta) + b cos(r theta)",
    .signature = "a line in the spectrum of the residual over the angle; `r` counts periods per turn of the joint",
    .source = "catalogue of causes",
    .look_alikes = "outliers, joint-gravity at low ratios",
    .separates = "slow motion at constant speed over several periods",
    .parameters = kParameters,
    .columns = kColumns,
    .needs = kNeeds,
    .of_rows = true,
    .on_robot = true,
    .places = 1000.0,  // ratios
    .on_gearbox = false,
    .fill = fill,
    .starts = starts,
    .counts = counts,
};

constexpr ActuatorEffect kHarmonics = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "harmonics";
  effect.equation = "tau += sum over k = 1 … 3 of a_k sin(k r theta) + b_k cos(k r theta)";
  effect.columns = kHarmonicColumns;
  effect.fill = fillHarmonics;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kHarmonics};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::position_ripple
