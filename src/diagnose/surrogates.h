/// \file
/// Signals that belong to no motion: what a cause's own signature has to beat.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace simgap {

/// A signal with the spectrum of `values` and phases drawn at random (surrogate data: Theiler et al. 1992), and the
/// same mean. \param draw  which of the surrogates: the same phases for every signal of one draw.
Eigen::VectorXd phaseRandomised(const Eigen::VectorXd& values, std::uint32_t draw, std::uint64_t seed);

}  // namespace simgap
