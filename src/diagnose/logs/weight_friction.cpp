#include "weight_friction.h"

#include <Eigen/QR>
#include <cmath>

namespace simgap {
namespace {

using Kind = EffectParameter::Kind;

constexpr EffectParameter kWeightParameters[] = {{"theta_0", "rad", -4.0, 4.0, 0.0, 0.0, Kind::kConstant}};
constexpr EffectColumn kWeightColumns[] = {{.name = "c", .unit = "Nm", .lower = 0.0}};

void fillWeight(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
                const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = (rows.joint_angle - p[0]).sin().abs() * terms.dry;
}

/// The angle at which the pendulum hangs, from its fitted column m g l sin(theta - theta_0) + m l^2 theta''.
double hangingAngle(const ActuatorData& data) {
  const ActuatorRows& rows = data.rows;
  Eigen::MatrixX3d parts(rows.rows(), 3);
  parts << rows.joint_angle.sin().matrix(), -rows.joint_angle.cos().matrix(), rows.acceleration.matrix();
  const Eigen::Vector3d c = parts.colPivHouseholderQr().solve(data.rig.col(0).matrix());
  return std::atan2(c[1], c[0]);
}

}  // namespace

const ActuatorEffect kWeightFriction = {
    .name = "weight-friction",
    .cause = "friction that grows with a weight that is fitted",
    .equation = "tau_fr += c |sin(theta - theta_0)| sign(w)",
    .signature = "steps at reversals that grow with the weight's torque",
    .source = "not a cause: what causes have to stand beside where no load is known",
    .look_alikes = "",
    .separates = "the same motion with another weight",
    .parameters = kWeightParameters,
    .columns = kWeightColumns,
    .fill = fillWeight,
};

std::optional<Beside> besideWeightFriction(const LogSearch& search, const Fitted& rest, const Fitted& full) {
  const ActuatorData& data = search.data();
  const FrictionLaw* law = search.base().law;
  if (!data.fits_weight || data.rows.joint_angle.size() == 0 || law == nullptr || law->needsLoad()) return std::nullopt;
  const Hypothesis weight{&kWeightFriction, {}, {hangingAngle(data)}};
  return Beside{search.beside(rest, weight), search.beside(full, weight)};
}

}  // namespace simgap
