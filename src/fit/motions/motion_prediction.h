/// \file
/// How large errors of motions will be that a fit has not seen. Their commands are known, only what was measured is
/// not. The mean square of motion m under the model found is drawn from
///
///     y_m = exp(u_m) + a_m(z),        a_m(z) = mean |f_m(z) - f_m(z_found)|^2
///
/// z: parameters from the posterior (Laplace's normal within the bounds, with the variance that the residuals show in
/// place of the one that their weights assume), the same for all motions of a draw; f_m: the motion played with them,
/// so that a movement that magnifies small errors counts as what it is. exp(u): what even the right parameters leave,
/// noise and discrepancy. Of motions fitted it is their mean square and what a fit takes away: E[y] = exp(u) - E[a],
/// where all a together, weighed, are as many as the parameters that the motions tell. Over motions
///
///     u_m ~ N(centre, tau^2 + 2/n_m)
///
/// n_m: numbers measured, of whose mean square white noise alone makes the logarithm vary by 2/n_m; tau: how else
/// motions differ. Six motions may look alike by chance, but none is told better than its noise. Both are drawn from
/// their posterior under a flat prior of the centre and p(tau) ~ (tau^2 + mean 2/n)^-1/2, on a grid: Student's t where
/// tau is large beside the noise, and proper from two motions on (random effects: Gelman et al., Bayesian Data
/// Analysis, section 5.4).
#pragma once

#include <optional>

#include "simgap/fit/motions/motion_calibration.h"

namespace simgap {

struct MotionPrediction {
  MotionRms median, lower, upper;  ///< 5 and 95 %
};

/// Of the root mean squares of a set. \param misfit  as of MotionCalibrationResult  \param fitted  mean squares of the
/// motions fitted  \param unseen  the set's motions with the same parameters
/// \returns nothing where fewer than two motions were fitted, or the motions cannot be played with parameters so drawn
/// \throws InterruptedError
std::optional<MotionPrediction> predictMotions(const MotionPosterior& posterior, const MotionFit& fit, double misfit,
                                               const std::vector<MotionRms>& fitted, const MotionPosterior& unseen);

}  // namespace simgap
