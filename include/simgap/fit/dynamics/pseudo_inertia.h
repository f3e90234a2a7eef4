/// \file
/// A body's ten inertial parameters by ten numbers of which any stands for a body that can exist. The pseudo-inertia
///
///     J = | S       m c |  = U U^T,   S = (tr I / 2) 1 - I
///         | (m c)^T m   |
///
/// (the second moments of its mass) is positive definite exactly then (Wensing, Kim & Slotine 2018), and so its factor
///
///     U = e^a | e^d1 s12  s13  t1 |
///             |      e^d2 s23  t2 |
///             |           e^d3 t3 |
///             |                1  |
///
/// has a positive diagonal: m = e^2a, t the centre of mass [m] (log-Cholesky: Rucker & Wensing 2022).
#pragma once

#include <Eigen/Core>

#include "simgap/model/arm/inverse_dynamics.h"

namespace simgap {

/// (a, d1, d2, d3, s12, s13, s23, t1, t2, t3)
using LogCholesky = BodyParameters;
using BodyJacobian = Eigen::Matrix<double, kBodyParameters, kBodyParameters>;

/// \param jacobian  unless null, d pi / d theta
BodyParameters bodyOf(const LogCholesky& theta, BodyJacobian* jacobian = nullptr);

/// Of a body of mass > 0. One that is thinner than 1 mm, as a root of its second moments about the centre, is made that
/// thick: a point or a rod has no finite theta.
LogCholesky logCholeskyOf(const BodyParameters& pi);

/// Smallest eigenvalue of the pseudo-inertia; > 0 for a body that can exist.
double smallestMoment(const BodyParameters& pi);

}  // namespace simgap
