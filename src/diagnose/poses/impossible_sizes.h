/// \file
/// Sizes of causes that no arm can have, however much more probable they make its poses: they stand for something else.
#pragma once

#include <string>

#include "pose_fit.h"

namespace simgap {

/// Why a cause of the fit, with the values of its solution, cannot be; empty when it can.
std::string impossibleSize(const PoseFit& fit, std::size_t cause);

}  // namespace simgap
