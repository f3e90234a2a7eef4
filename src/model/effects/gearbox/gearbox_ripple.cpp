/// \file
/// Tooth mesh or an eccentric wheel: a torque that repeats with the shaft angle, a sin(r phi) + b cos(r phi), phi the
/// logged motor angle or, without one, the integral of the speed.
#include "simgap/model/effects/actuator_effect.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/effects/spectral_peaks.h"

namespace simgap::actuator_effects::gearbox_ripple {
namespace {

constexpr EffectParameter kParameters[] = {{"r", "1", 1e-4, 1e4, 1.0, 1.0, EffectParameter::Kind::kShape}};
constexpr EffectColumn kColumns[] = {{"a", "Nm"}, {"b", "Nm"}};

Eigen::ArrayXd shaftAngle(const ActuatorRows& rows) {
  if (rows.motor_angle.size() > 0) return rows.motor_angle;
  if (rows.joint_angle.size() > 0) return rows.joint_angle;
  Eigen::ArrayXd angle = Eigen::ArrayXd::Zero(rows.rows());
  for (Eigen::Index i = 1; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double dt = rows.session[k] == rows.session[k - 1] ? rows.time[i] - rows.time[i - 1] : 0.0;
    angle[i] = angle[i - 1] + 0.5 * dt * (rows.speed[i] + rows.speed[i - 1]);
  }
  return angle;
}

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  const Eigen::ArrayXd angle = shaftAngle(rows);
  x.col(0) = (p[0] * angle).sin();
  x.col(1) = (p[0] * angle).cos();
}

bool counts(std::span<const double> p, const ActuatorRows& rows) { return repeats(p[0], shaftAngle(rows)); }

/// Power of the residual over the angle, on a grid that resolves it; the strongest peaks. An integrated angle drifts,
/// and a fine peak with it: the grid is of the whole turns of the motor and of their first fractions and multiples.
std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& residual) {
  constexpr int kPeaks = 4, kGrid = 3000;
  const Eigen::ArrayXd angle = shaftAngle(rows);
  const double span = angle.maxCoeff() - angle.minCoeff();
  if (!(span > 0.0)) return {};
  const double lowest = 2.0 * std::numbers::pi / span;
  // Faster than half a turn between rows no ripple can be seen.
  const double travel = std::sqrt(rows.speed.square().mean()) * rows.step;
  const double highest = std::min(std::numbers::pi / std::max(travel, 1e-9), lowest * kGrid / 4.0);
  const Eigen::Index stride = std::max<Eigen::Index>(1, rows.rows() / 6000);
  const auto power = [&](double r) {
    double s = 0.0, c = 0.0;
    for (Eigen::Index i = 0; i < rows.rows(); i += stride) {
      s += residual[i] * std::sin(r * angle[i]);
      c += residual[i] * std::cos(r * angle[i]);
    }
    return s * s + c * c;
  };
  std::vector<std::vector<double>> list;
  for (const double ratio : strongestPeaks(lowest, highest, 0.25 * lowest, kPeaks, power)) list.push_back({ratio});
  for (const double turn : {1.0, 2.0}) list.push_back({turn});
  return list;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "gearbox-ripple",
    .kind = ActuatorKind::kGearbox,
    .cause = "tooth mesh or an eccentric wheel: a torque that repeats with the shaft angle",
    .equation = "tau += a sin(r phi) + b cos(r phi)",
    .signature = "a line in the spectrum over the shaft angle",
    .source = "catalogue of causes",
    .look_alikes = "outliers, drift at low ratios",
    .separates = "slow motion at constant speed over several turns, with the shaft angle logged",
    .parameters = kParameters,
    .columns = kColumns,
    .of_rows = true,
    .needs_all_rows = true,
    .fill = fill,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::gearbox_ripple
