/// \file
/// The sleeve's rubber creeps: a part of the force dies away within seconds after every change,
///
///     f -= share z,   tau dz/dt = f - z,
///
/// z solved exactly for a force that is constant between rows. With `decades` = 2 the share is that of five such parts
/// together, from tau / 10 to 10 tau. A session begins settled or, with `carried` = 1, as the one before it ended.
#include <cmath>

#include "model/effects/relaxation.h"
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::muscle_creep {
namespace {

constexpr EffectParameter kParameters[] = {{"tau", "s", 1e-2, 1e4, 10.0, 10.0, EffectParameter::Kind::kShape},
                                           {"carried", "1", 0.0, 1.0, 0.0, 0.0, EffectParameter::Kind::kConstant},
                                           {"decades", "1", 0.0, 4.0, 0.0, 0.0, EffectParameter::Kind::kConstant}};
constexpr EffectColumn kColumns[] = {{.name = "share", .unit = "1", .lower = 0.0, .upper = 0.5, .torque = false}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.setZero();
  const int branches = branchCount(p[2]);
  for (int b = 0; b < branches; ++b) {
    const double tau = branchTime(p[0], p[2], b);
    double z = 0.0;
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const bool begins = i == 0 || rows.session[k] != rows.session[k - 1];
      if (i == 0 || (begins && p[1] == 0.0)) {
        z = terms.effort[i];
      } else if (!begins) {
        z += (1.0 - std::exp(-(rows.time[i] - rows.time[i - 1]) / tau)) * (terms.effort[i - 1] - z);
      }
      x(i, 0) -= z / branches;
    }
  }
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  const bool several = rows.session.back() != rows.session.front();
  for (const double decades : {0.0, 2.0}) {
    for (const double part : {0.0, 0.33, 0.67, 1.0}) {
      const double tau = relaxationTime(rows, part);
      list.push_back({tau, 0.0, decades});
      if (several) list.push_back({tau, 1.0, decades});
    }
  }
  return list;
}

/// Slower than that it is force itself.
bool counts(std::span<const double> p, const ActuatorRows& rows) { return showsRelaxation(rows, p[0]); }

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kTime};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "muscle-creep",
    .kind = ActuatorKind::kPam,
    .cause = "the rubber of the muscle creeps: a part of the force dies away for seconds after every change",
    .equation = "f -= share z, tau dz/dt = f - z",
    .signature = "force falls for a while after every rise, and rises after every fall",
    .remarks =
        "every session begins settled (`carried` = 0) or as the one before it ended, and one relaxation time "
        "(`decades` = 0) or five over two decades about tau: as the data choose",
    .source = "Maxwell 1867; Wiechert 1893",
    .look_alikes = "force-bias, contraction-hysteresis, a valve's lag",
    .separates = "steps of pressure at a fixed length, each held for some tau",
    .parameters = kParameters,
    .columns = kColumns,
    .needs = kNeeds,
    .implicit = true,
    .remembers = true,
    .needs_all_rows = true,
    .fill = fill,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::muscle_creep
