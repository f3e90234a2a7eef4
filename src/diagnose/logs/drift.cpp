#include "drift.h"

#include <algorithm>

namespace simgap {
namespace {

/// At the ends of as many equal parts of the log; 0 at its beginning.
constexpr EffectParameter frictionAt(std::string_view name) { return {name, "1", -0.9, 3.0, 0.0, 0.0}; }
constexpr EffectParameter kDriftParameters[] = {frictionAt("a_1"), frictionAt("a_2"), frictionAt("a_3"),
                                                frictionAt("a_4"), frictionAt("a_5"), frictionAt("a_6"),
                                                frictionAt("a_7"), frictionAt("a_8")};
constexpr EffectColumn kDriftColumns[] = {{.name = "c", .unit = "A", .torque = false},
                                          {.name = "d", .unit = "A", .torque = false}};

/// The part of the log that is over, 0 to 1.
Eigen::ArrayXd over(const ActuatorRows& rows) {
  const double begin = rows.elapsed[0], length = rows.elapsed[rows.rows() - 1] - begin;
  return (rows.elapsed - begin) / std::max(length, 1e-9);
}

void applyDrift(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const Eigen::ArrayXd parts = over(rows) * static_cast<double>(p.size());
  Eigen::ArrayXd factor = Eigen::ArrayXd::Ones(rows.rows());
  for (std::size_t k = 0; k < p.size(); ++k) {
    factor += p[k] * (1.0 - (parts - static_cast<double>(k + 1)).abs()).max(0.0);
  }
  terms.dry *= factor.max(0.02);
}

void fillDrift(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
               const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = 1.0;
  x.col(1) = over(rows);
}

constexpr ActuatorEffect kDrift = {
    .name = "drift",
    .cause = "friction and effort drift over the log",
    .equation = "tau_dry (1 + a(u)), I + c + d u, u = the part of the log that is over",
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

Fitted besideDrift(const LogSearch& search, const Fitted& rest) {
  return search.beside(rest, {&kDrift, {}, std::vector<double>(std::size(kDriftParameters), 0.0)});
}

}  // namespace simgap
