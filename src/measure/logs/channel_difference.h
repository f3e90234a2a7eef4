/// \file
/// What one channel has and another of the same rows has not.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

namespace simgap {

/// a - b, row by row. \param a, b  shape (rows)
inline std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  std::ranges::transform(a, b, result.begin(), std::minus<>());
  return result;
}

}  // namespace simgap
