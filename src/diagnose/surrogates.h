/// \file
/// Signals that belong to no motion: what a cause's own signature has to beat.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

namespace simgap {

inline constexpr std::uint32_t kPlacebos = 39;  ///< of a cause: one of them may reach it at a level of 5 %
inline constexpr double kPlaceboLevel = 0.05;   ///< above which placebos explain as much

/// How often placebos gain as much, one more counted on either side.
double placeboP(double gain, std::span<const double> of_placebos);

/// A signal with the spectrum of `values` and phases drawn at random (surrogate data: Theiler et al. 1992), and the
/// same mean. \param draw  which of the surrogates: the same phases for every signal of one draw.
Eigen::VectorXd phaseRandomised(const Eigen::VectorXd& values, std::uint32_t draw, std::uint64_t seed);

}  // namespace simgap
