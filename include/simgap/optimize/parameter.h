/// \file
/// The two things that are said of a parameter: where it may lie, and what was found.
#pragma once

#include <limits>
#include <string>

namespace simgap {

/// What a parameter is before anything is fitted.
struct ParameterSpec {
  std::string name;
  std::string unit;  ///< SI, as a suffix; "1" when dimensionless
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool fixed = false;
};

/// The value of a parameter, with what is known of it.
struct Estimate {
  std::string name;
  std::string unit;  ///< SI, as a suffix; "1" when dimensionless
  double value = 0.0;
  double sd = 0.0;           ///< NaN when unknown, or when the data do not determine it
  bool fixed = false;        ///< given, not estimated
  bool at_bound = false;     ///< the value sits on a bound of its specification
  bool identifiable = true;  ///< the data determine it
  double lower95 = std::numeric_limits<double>::quiet_NaN();  ///< 95 % interval; one-sided at a bound; NaN when unknown
  double upper95 = std::numeric_limits<double>::quiet_NaN();
};

/// With as much on both sides of the value.
inline Estimate withInterval(Estimate estimate, double half) {
  estimate.lower95 = estimate.value - half;
  estimate.upper95 = estimate.value + half;
  return estimate;
}

}  // namespace simgap
