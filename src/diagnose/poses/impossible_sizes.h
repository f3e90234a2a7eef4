/// \file
/// Sizes of causes that no arm can have, however much more probable they make its poses: they stand for something else.
#pragma once

#include <span>
#include <string>

#include "pose_fit.h"

namespace simgap {

/// Why a cause of the fit, with the values of its solution, cannot be; empty when it can.
std::string impossibleSize(const PoseFit& fit, std::size_t cause);

/// How far off level a base is [rad]. \param turn  parameters of a cause that turns gravity
double tiltOf(std::span<const Estimate> turn);

}  // namespace simgap
