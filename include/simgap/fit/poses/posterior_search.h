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
  bool on_ranks = false;  ///< share the descents among all ranks, which then have to search at the same time
};

/// What a search has found so far: one that is begun anew with it goes on to the same end, to the bit.
struct SearchJournal {
  Eigen::VectorXd whitened_at;     ///< z of the whitening under which the fits compare; shape (0): before the first
  std::vector<PosteriorFit> fits;  ///< finished descents in their order
};

/// Called after every start or round, in a fixed order, with what it found; true ends the search there.
using AfterFit = std::function<bool(const PosteriorFit& fit)>;

/// Descends from every start and leaves `posterior` with the whitening under which the fits are compared: that of the
/// first start's solution, of many poses a rough one. Of many poses every start first descends on some hundred; starts
/// that end in one valley there share the descent of the lowest of them on all poses. An interrupt ends it; what was
/// not finished is not in the journal.
/// \param journal  of an earlier session, or empty; its fits are passed on to `after_fit` too
/// \returns a fit of every start: the first one's, those of starts with a descent of their own, those that share one;
///          the same for any number of threads
std::vector<PosteriorFit> searchPosterior(PosePosterior& posterior, const PosteriorSearchOptions& options,
                                          SearchJournal& journal, const AfterFit& after_fit);

/// The same, of a new search.
std::vector<PosteriorFit> searchPosterior(PosePosterior& posterior, const PosteriorSearchOptions& options = {});

/// Hybrid: starts as above; then, `kHybridRounds` times, the evolution strategy explores around the mu best fits for
/// `kHybridGenerations` generations and the mu best individuals are polished by descent.
void searchHybrid(PosePosterior& posterior, const PosteriorSearchOptions& options,
                  const EvolutionStrategyOptions& strategy, SearchJournal& journal, const AfterFit& after_fit);

inline constexpr int kHybridRounds = 3;
inline constexpr int kHybridGenerations = 8;
inline constexpr double kHybridStep = 0.3;  ///< of the exploration, in standard deviations of the priors

}  // namespace simgap
