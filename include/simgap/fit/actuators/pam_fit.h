/// \file
/// Fits a pneumatic muscle (002 section III): force against pressure and apparent contraction, with and without the
/// tendon's spring, from one log, or in the paper's two stages: a, b, c from the maker's curves, then k from the rig.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/model/actuator/pam.h"

namespace simgap {

struct PamFitOptions {
  bool spring = true;  ///< k is a parameter; otherwise infinite
  bool tied = false;   ///< b = -2a, as geometry demands (002 eq. 12)
  std::map<std::string, double> fixed;
  std::map<std::string, Bounds> bounds;
};

struct PamFit {
  std::vector<double> theta;  ///< a, b, c, k
  Uncertainty uncertainty;
  double mse = 0.0;  ///< [N^2]
  std::size_t n = 0, parameters = 0, starts = 0, distinct_minima = 0;
  std::vector<std::string> warnings;
  Pam muscle() const;
};

/// \param rows  shape (log rows): which to use; all when empty.
/// \throws DataError: too few rows, a constant force, a force or contraction with the opposite sign.
PamFit fitPam(const PamLog& log, const PamFitOptions& options, const std::vector<bool>& rows = {});

/// What a muscle (unbounded) pulls in a row of a log, less what the one that is like it and opposes it pulls. [N]
double predictedForce(const Pam& muscle, const PamLog& log, std::size_t row);
double meanSquaredError(const PamFit& fit, const PamLog& log, const std::vector<bool>& rows);

/// Diameter [m] and braid angle [rad] that give a and c (002 eq. 12); empty when no geometry does.
struct PamGeometry {
  double diameter, angle;
};
std::optional<PamGeometry> geometryOf(double a, double c);

}  // namespace simgap
