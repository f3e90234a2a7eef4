/// \file
/// Several friction laws fitted to the same rows of a log and judged on others (003 table 2).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "simgap/fit/actuators/friction_fit.h"

namespace simgap {

struct FrictionComparison {
  std::vector<FrictionFit> fits;      ///< at least one
  std::size_t best = 0;               ///< the lowest BIC
  std::string heldout;                ///< how rows were held out, in words
  std::vector<std::string> left_out;  ///< laws that the log cannot answer, with the reason
};

/// The laws of a user's list, each once: a name, "all" for the three of 003 table 2, "every" for every law there is.
/// \throws ConfigError: an unknown name.
std::vector<const FrictionLaw*> lawsNamed(std::span<const std::string> names);

/// Names of the parameters of all laws on that log, in order, some several times.
std::vector<std::string> parameterNames(std::span<const FrictionLaw* const> laws, const FrictionData& data,
                                        const FrictionFitOptions& options);

/// \param test  rows that judge instead of the cross-validation; may be null. \param words  says which they are.
/// \throws DataError when no law can be fitted.
FrictionComparison compareLaws(std::span<const FrictionLaw* const> laws, const FrictionData& data,
                               const FrictionFitOptions& options, const FrictionData* test, const std::string& words);

}  // namespace simgap
