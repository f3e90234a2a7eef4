/// \file
/// Which channel of a motor's log has the wrong sign.
#pragma once

#include <span>
#include <string>

namespace simgap {

/// A sentence about the current or the velocity when turning it round leaves less than half of the squared error that a
/// winding leaves as it is, V = R i + K_E w + offset with R, K_E >= 0; empty when neither does.
/// \param voltage  [V], shape (n)  \param current  [A]  \param velocity  [rad/s]
std::string oppositeWindingSign(std::span<const double> voltage, std::span<const double> current,
                                std::span<const double> velocity);

}  // namespace simgap
