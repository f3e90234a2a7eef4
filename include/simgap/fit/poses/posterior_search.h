/// \file
/// The most probable parameters from several starts, by descent alone or between rounds of an evolution strategy.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "simgap/fit/poses/levenberg_marquardt.h"
#include "simgap/optimize/evolution_strategy.h"

namespace simgap {

struct PosteriorSearchOptions {
  int starts =
      8;  ///< the model itself, then draws from the priors, each first brought near the poses by balanceTorques
  int threads = 0;  ///< 0: all
  std::uint64_t seed = 1;
};

/// Called after every start or round, in a fixed order, with what it found; true ends the search there.
using AfterFit = std::function<bool(const PosteriorFit& fit)>;

/// Descends from every start and leaves `posterior` with the whitening under which the fits are compared: that of the
/// first start's solution. \returns all fits, in the order of the starts; the same for any number of threads
std::vector<PosteriorFit> searchPosterior(PosePosterior& posterior, const PosteriorSearchOptions& options,
                                          const AfterFit& after_fit);

/// Hybrid: starts as above; then, `kHybridRounds` times, the evolution strategy explores around the mu best fits for
/// `kHybridGenerations` generations and the mu best individuals are polished by descent. \returns the best fit
PosteriorFit searchHybrid(PosePosterior& posterior, const PosteriorSearchOptions& options,
                          const EvolutionStrategyOptions& strategy, const AfterFit& after_fit);

inline constexpr int kHybridRounds = 3;
inline constexpr int kHybridGenerations = 8;
inline constexpr double kHybridStep = 0.3;  ///< of the exploration, in standard deviations of the priors

}  // namespace simgap
