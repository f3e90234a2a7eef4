/// \file
/// Pneumatic artificial muscle with the spring of its tendon (002 section III), for simulators and controllers: one
/// header without dependencies.
///
///     f = p g(eps + f / k),   g(x) = a x^2 + b x + c                    002 eq. 13, 14, 16
///
/// eps is the apparent contraction, of muscle and tendon together; the tendon stretches by f / k (k in N per unit of
/// contraction), so the muscle itself contracts by eps + f / k. k = infinity leaves the tendon out.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

namespace simgap {

struct Pam {
  double a = 0.0;                                      ///< [m^2] N per Pa
  double b = 0.0;                                      ///< [m^2]
  double c = 0.0;                                      ///< [m^2]
  double k = std::numeric_limits<double>::infinity();  ///< [N]
  double lowest = -0.05;                               ///< contraction of the muscle itself: its range
  double highest = 0.35;

  double area(double contraction) const noexcept { return (a * contraction + b) * contraction + c; }

  /// Contraction of the muscle itself at which it pulls no more: the smaller root of g. NaN when g has none.
  double slack() const noexcept { return 2.0 * c / (-b + std::sqrt(b * b - 4.0 * a * c)); }

  /// Force at a pressure [Pa] and an apparent contraction: the physical root of the quadratic, >= 0. Empty when the
  /// muscle would leave its contraction range.
  std::optional<double> force(double pressure, double contraction) const noexcept {
    double f = pressure * area(contraction);
    if (f > 0.0 && std::isfinite(k)) {
      const double quadratic = pressure * a / (k * k);
      const double linear = pressure * (2.0 * a * contraction + b) / k - 1.0;
      const double root = linear * linear - 4.0 * quadratic * f;
      if (root < 0.0) return std::nullopt;
      f = 2.0 * f / (-linear + std::sqrt(root));  // the branch that is p g(eps) for a stiff tendon
    }
    f = f > 0.0 ? f : 0.0;
    return inRange(contraction, f) ? std::optional(f) : std::nullopt;
  }

  /// df / d eps at a constant pressure: p g' / (1 - p g' / k), 0 when slack or outside the range. [N]
  double slope(double pressure, double contraction) const noexcept {
    const double f = force(pressure, contraction).value_or(0.0);
    if (f <= 0.0) return 0.0;
    const double rigid = pressure * (2.0 * a * (contraction + f / k) + b);
    return rigid / (1.0 - rigid / k);
  }

  /// Where no force solves the equation, because the spring is too soft: the force at which p g(eps + f / k) comes
  /// nearest to f, the vertex of the quadratic. Needs a finite k and p a > 0.
  double turningForce(double pressure, double contraction) const noexcept {
    return k * (k / (2.0 * pressure * a) - contraction - b / (2.0 * a));
  }

  /// Pressure [Pa] for a force >= 0 [N] at an apparent contraction (002 eq. 17). Empty outside the contraction range,
  /// and where no pressure gives the force.
  std::optional<double> pressure(double force, double contraction) const noexcept {
    if (force < 0.0 || !inRange(contraction, force)) return std::nullopt;
    const double gain = area(contraction + force / k);
    return gain > 0.0 ? std::optional(force / gain) : std::nullopt;
  }

 private:
  bool inRange(double contraction, double force) const noexcept {
    const double own = contraction + force / k;
    return own >= lowest && own <= highest;
  }
};

}  // namespace simgap
