/// A pneumatic artificial muscle and its tendon (002 section III), as `fit-pam` identifies it:
///
///   f = p g(eps + f/k),   g(x) = a x^2 + b x + c,   eps = (rest_length - L) / muscle_length     002 eq. 13, 14, 16
///
/// L is the length of muscle and tendon together, x = eps + f/k the contraction of the muscle alone. With x as the
/// independent variable everything is closed: eps = x - p g(x)/k, and with G' = g and x_e the contraction at which the
/// muscle pulls no more,
///
///   V = muscle_length (p (G(x_e) - G(x)) + p^2 (g(x)^2 - g(x_e)^2) / 2k),   df/d eps = p g' / (1 - p g'/k).
///
/// Between the muscle's range of contraction and x_e the parabola is continued; beyond x_e the muscle is slack. Where
/// g never falls to 0, x_e is its lowest place, and the force there lasts.
///
/// In motions the pressure follows its command as a valve fills the muscle, dp/dt = (p_ref - p)/fill_time: the
/// isothermal filling of a constant volume through a linear throttle.
#include <algorithm>
#include <cmath>

#include "simgap/model/arm/tendon_kind.h"

namespace simgap::tendon_kinds::pneumatic_muscle {
namespace {

constexpr Range kFalling{-kInfinity, -1e-12, false, "a number < 0: force falls as the muscle contracts"};
constexpr TendonParameter kParameters[] = {{"a", "m2", "a_m2", kNonNegative},
                                           {"b", "m2", "b_m2", kFalling},
                                           {"c", "m2", "c_m2", kPositive},
                                           {"k", "N", "k_N", kPositive},
                                           {"muscle_length", "m", "muscle_length_m", kPositive},
                                           {"rest_length", "m", "rest_length_m", kAnyNumber},
                                           {"damping", "Ns_m", "damping_Ns_m", kNonNegative},
                                           {"fill_time", "s", "fill_time_s", kNonNegative, 0.0}};
constexpr int kFillTime = 7;

struct Law {
  double a, b, c, k, length, rest;
  explicit Law(const TendonParameters& p) : a(p[0]), b(p[1]), c(p[2]), k(p[3]), length(p[4]), rest(p[5]) {}
  double area(double x) const { return (a * x + b) * x + c; }
  double areaSlope(double x) const { return 2.0 * a * x + b; }
  double areaIntegral(double x) const { return ((a / 3.0 * x + b / 2.0) * x + c) * x; }
  double discriminant() const { return b * b - 4.0 * a * c; }
  /// x_e: the smaller root of g or, without one, its vertex.
  double end() const { return discriminant() > 0.0 ? 2.0 * c / (-b + std::sqrt(discriminant())) : -b / (2.0 * a); }
  double endArea() const { return discriminant() > 0.0 ? 0.0 : area(end()); }
};

TendonPull pull(const TendonParameters& p, double line_length, double command) {
  const Law law(p);
  const double pressure = std::max(0.0, command);
  const double eps = (law.rest - line_length) / law.length;
  const double end = law.end(), end_force = pressure * law.endArea(), eps_end = end - end_force / law.k;
  const bool taut = eps < eps_end;
  // p a/k x^2 + (p b/k - 1) x + p c/k + eps = 0: its smaller root
  const double linear = 1.0 - pressure * law.b / law.k, constant = pressure * law.c / law.k + eps;
  const double root = std::max(0.0, linear * linear - 4.0 * pressure * law.a / law.k * constant);
  const double x = taut ? 2.0 * constant / (linear + std::sqrt(root)) : end;

  const double area = taut ? std::max(0.0, law.area(x)) : law.endArea(), slope = taut ? law.areaSlope(x) : 0.0;
  const double force = pressure * area, share = 1.0 / (1.0 - pressure * slope / law.k);
  const double by_eps = pressure * slope * share;
  TendonPull pull;
  pull.force = force;
  pull.stiffness = -by_eps / law.length;
  if (taut) {
    pull.energy = law.length * (pressure * (law.areaIntegral(end) - law.areaIntegral(x)) +
                                0.5 * (force * force - end_force * end_force) / law.k);
  } else {
    pull.energy = -law.length * force * (eps - eps_end);
  }
  const double by_area = area > 0.0 ? pressure * share : 0.0;
  pull.by_parameter = {
      by_area * x * x,     by_area * x, by_area, -by_eps * force / (law.k * law.k), -by_eps * eps / law.length,
      by_eps / law.length, 0.0,         0.0};
  pull.by_command = command < 0.0 ? 0.0 : area * share;
  return pull;
}

double force(const TendonParameters& p, double line_length, double rate, double command) {
  const double elastic = pull(p, line_length, command).force;
  return elastic > 0.0 ? std::max(0.0, elastic + p[6] * rate) : 0.0;
}

}  // namespace

extern const TendonKind entry;
const TendonKind entry{
    .name = "pneumatic-muscle",
    .what = "a pneumatic artificial muscle with its tendon, under a pressure",
    .equation = "F = p g(eps + F/k), g(x) = a x^2 + b x + c, eps = (rest_length - L)/muscle_length",
    .parameters = kParameters,
    .pull = pull,
    .force = force,
    .command = {.quantity = "pressure", .unit = "Pa", .typical = 2e5, .lowest = 0.0, .lag = kFillTime}};

}  // namespace simgap::tendon_kinds::pneumatic_muscle
