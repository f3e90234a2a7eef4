/// \file
/// The rubber of a muscle, and the air that is pushed through its ports, resist the rate of the contraction,
///
///     f -= c d eps / dt
#include <algorithm>

#include "simgap/core/blocks.h"
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::contraction_damping {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr EffectColumn kColumns[] = {{.name = "c", .unit = "Ns", .lower = 0.0, .torque = false}};
constexpr OptionalChannel kNeeds[] = {OptionalChannel::kTime};

/// d eps / dt [1/s], shape (n): rows know how far they went of their session's range.
ArrayXd rateOf(const ActuatorRows& rows) {
  ArrayXd rate = ArrayXd::Zero(rows.rows());
  for (const Block& b : splitRows(rows.session, rows.session.size())) {
    const auto session = rows.contraction.segment(static_cast<Index>(b.begin), static_cast<Index>(b.size()));
    const double range = session.maxCoeff() - session.minCoeff();
    for (auto i = static_cast<Index>(b.begin) + 1; i < static_cast<Index>(b.end); ++i) {
      rate[i] = rows.direction[i] * rows.travel[i] * range / std::max(rows.time[i] - rows.time[i - 1], 1e-9);
    }
  }
  return rate;
}

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = -rateOf(rows);
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "contraction-damping",
    .kind = ActuatorKind::kPam,
    .cause = "the muscle resists the rate of its contraction, as a damper beside it would",
    .equation = "f -= c d eps / dt",
    .signature = "force over contraction runs round a loop that is the wider the faster it goes",
    .source = "Reynolds et al. 2003",
    .look_alikes = "contraction-hysteresis and a valve's lag, where all motions are equally fast",
    .separates = "the same lengths and pressures passed slowly and fast: friction's loop stays as wide",
    .columns = kColumns,
    .needs = kNeeds,
    .needs_all_rows = true,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::contraction_damping
