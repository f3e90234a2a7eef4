/// \file
/// A part of the force dies away while the deflection stands: a Maxwell branch, spring and damper in series,
///
///     F += stiffness y,   dy/dt = dx/dt - y / tau,
///
/// solved exactly for a deflection that changes linearly between rows. Cords have many such branches: with `decades` =
/// 2 the stiffness is shared by five of them, from tau / 10 to 10 tau. Every session begins relaxed.
#include <cmath>

#include "model/effects/relaxation.h"
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::spring_creep {
namespace {

constexpr EffectParameter kParameters[] = {{"tau", "s", 1e-3, 1e4, 1.0, 1.0, EffectParameter::Kind::kShape},
                                           {"decades", "1", 0.0, 4.0, 0.0, 0.0, EffectParameter::Kind::kConstant}};
constexpr EffectColumn kColumns[] = {{.name = "stiffness", .unit = "Nm_rad", .lower = 0.0, .torque = false}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.setZero();
  const int branches = branchCount(p[1]);
  for (int b = 0; b < branches; ++b) {
    x.col(0) += 1.0 / branches * maxwellBranch(rows, branchTime(p[0], p[1], b), terms.deflection);
  }
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  constexpr int kCount = 5;
  std::vector<std::vector<double>> list;
  for (const double decades : {0.0, 2.0}) {
    for (int k = 0; k < kCount; ++k) list.push_back({relaxationTime(rows, k / (kCount - 1.0)), decades});
  }
  return list;
}

/// Slower than that it is stiffness, or time itself.
bool counts(std::span<const double> p, const ActuatorRows& rows) { return showsRelaxation(rows, p[0]); }

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kTime};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "spring-creep",
    .kind = ActuatorKind::kSpring,
    .cause = "a part of the force dies away while the deflection stands: the material creeps",
    .equation = "F += stiffness y, dy/dt = dx/dt - y / tau",
    .signature = "force falls during rests after a pull and rises after a release; loops are wider at one speed",
    .remarks = "one relaxation time (`decades` = 0) or five over two decades about tau, as the data choose",
    .source = "Maxwell 1867; Wiechert 1893",
    .look_alikes = "spring-hysteresis when all motions have one speed",
    .separates = "rests of some tau after fast pulls to several deflections, and slow loops beside fast ones",
    .parameters = kParameters,
    .columns = kColumns,
    .needs = kNeeds,
    .needs_all_rows = true,
    .fill = fill,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::spring_creep
