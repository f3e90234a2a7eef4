#include "drift.h"

#include <algorithm>

namespace simgap {
namespace {

constexpr EffectParameter kDriftParameters[] = {{"a", "1", -0.9, 3.0, 0.0, 0.0}};
constexpr EffectColumn kDriftColumns[] = {{.name = "c", .unit = "A", .torque = false},
                                          {.name = "d", .unit = "A", .torque = false}};

/// The part of the log that is over, 0 to 1.
Eigen::ArrayXd over(const ActuatorRows& rows) {
  const double begin = rows.elapsed[0], length = rows.elapsed[rows.rows() - 1] - begin;
  return (rows.elapsed - begin) / std::max(length, 1e-9);
}

void applyDrift(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.dry *= 1.0 + p[0] * over(rows);
}

void fillDrift(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
               const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = 1.0;
  x.col(1) = over(rows);
}

constexpr ActuatorEffect kDrift = {
    .name = "drift",
    .cause = "friction and effort drift over the log",
    .equation = "tau_dry (1 + a u), I + c + d u, u = the part of the log that is over",
    .signature = "a residual that grows over the log",
    .source = "not a cause: what a change at one moment has to explain more than",
    .look_alikes = "",
    .separates = "the first motion of the log once more at its end",
    .parameters = kDriftParameters,
    .columns = kDriftColumns,
    .apply = applyDrift,
    .fill = fillDrift,
};

}  // namespace

Fitted besideDrift(const LogSearch& search, const Fitted& rest) { return search.beside(rest, {&kDrift, {}, {0.0}}); }

}  // namespace simgap
