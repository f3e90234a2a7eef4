#include "simgap/fit/poses/posterior_search.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"

namespace simgap {
namespace {

constexpr std::uint32_t kStartPurpose = 3;  // 1 and 2 are the evolution strategy's

/// Calls action(posterior, i) for i = 0 … count - 1, each thread with a posterior of its own.
template <class Action>
void inParallel(const PosePosterior& posterior, int threads, std::size_t count, const Action& action) {
  tbb::enumerable_thread_specific<PosePosterior> own(posterior);
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      if (!interruptRequested()) action(own.local(), i);
    });
  });
}

Eigen::VectorXd drawStart(const ScaledParameters& parameters, std::uint64_t seed, std::size_t start) {
  Eigen::VectorXd z = Eigen::VectorXd::Zero(parameters.size());
  const CounterRandom random(seed);
  for (Eigen::Index i = 0; start > 0 && i < z.size(); ++i) {
    const RandomCounter counter{0, static_cast<std::uint32_t>(start), static_cast<std::uint32_t>(i), kStartPurpose};
    z[i] = std::clamp(random.normalPair(counter)[0], parameters.lower(i), parameters.upper(i));
  }
  return z;
}

/// Descends from each z; a posterior's whitening is not changed by that.
std::vector<PosteriorFit> polishAll(const PosePosterior& posterior, int threads,
                                    const std::vector<Eigen::VectorXd>& z) {
  std::vector<PosteriorFit> fits(z.size());
  inParallel(posterior, threads, z.size(),
             [&](PosePosterior& own, std::size_t i) { fits[i] = descendPosterior(own, z[i]); });
  return fits;
}

bool better(const PosteriorFit& a, const PosteriorFit& b) { return a.objective < b.objective; }

}  // namespace

std::vector<PosteriorFit> searchPosterior(PosePosterior& posterior, const PosteriorSearchOptions& options,
                                          const AfterFit& after_fit) {
  std::vector<PosteriorFit> fits;
  {
    PosePosterior own = posterior;  // balancing changes the whitening
    const Eigen::VectorXd z = balanceTorques(own, drawStart(posterior.parameters(), options.seed, 0));
    own.whiten(z);
    const PosteriorFit first = descendPosterior(own, z);
    posterior.whiten(first.z);
    fits.push_back(descendPosterior(posterior, first.z));
    fits.back().iterations += first.iterations;
    fits.back().evaluations += first.evaluations;
    if (after_fit(fits.back())) return fits;
  }
  const auto others = static_cast<std::size_t>(std::max(0, options.starts - 1));
  std::vector<PosteriorFit> found(others);
  inParallel(posterior, options.threads, others, [&](PosePosterior& own, std::size_t i) {
    PosePosterior balancing = own;
    const Eigen::VectorXd z = drawStart(posterior.parameters(), options.seed, i + 1);
    found[i] = descendPosterior(own, balanceTorques(balancing, z));
  });
  for (const PosteriorFit& fit : found) {
    if (interruptRequested() || after_fit(fit)) break;
    fits.push_back(fit);
  }
  return fits;
}

PosteriorFit searchHybrid(PosePosterior& posterior, const PosteriorSearchOptions& options,
                          const EvolutionStrategyOptions& strategy, const AfterFit& after_fit) {
  bool stop = false;
  std::vector<PosteriorFit> best = searchPosterior(posterior, options, [&](const PosteriorFit& fit) {
    stop = after_fit(fit);
    return stop;
  });
  const auto mu = static_cast<std::size_t>(strategy.mu);
  const auto keepBest = [&] {
    std::stable_sort(best.begin(), best.end(), better);
    if (best.size() > mu) best.resize(mu);
  };
  keepBest();
  std::vector<ObjectParameter> space;
  for (Eigen::Index i = 0; i < posterior.parameters().size(); ++i) {
    space.push_back({0.0, kHybridStep, posterior.parameters().lower(i), posterior.parameters().upper(i)});
  }
  for (int round = 1; round <= kHybridRounds && !stop && !interruptRequested(); ++round) {
    EvolutionStrategyState state;
    for (const PosteriorFit& fit : best) {
      state.parents.push_back(
          {{fit.z.begin(), fit.z.end()}, std::vector<double>(space.size(), kHybridStep), fit.objective});
    }
    state.best = state.parents.front();
    EvolutionStrategyOptions exploration = strategy;
    exploration.generations = kHybridGenerations;
    exploration.seed = strategy.seed + static_cast<std::uint64_t>(round);
    EvolutionStrategy explorer(space, exploration, state);
    while (!explorer.stopped() && !interruptRequested()) {
      const std::vector<Individual>& offspring = explorer.ask();
      std::vector<double> objectives(offspring.size());
      inParallel(posterior, options.threads, offspring.size(), [&](PosePosterior& own, std::size_t k) {
        objectives[k] = own.objective(Eigen::Map<const Eigen::VectorXd>(offspring[k].y.data(), std::ssize(space)));
      });
      explorer.tell(objectives);
    }
    std::vector<Eigen::VectorXd> starts;
    for (const Individual& parent : explorer.state().parents) {
      starts.emplace_back(Eigen::Map<const Eigen::VectorXd>(parent.y.data(), std::ssize(space)));
    }
    std::vector<PosteriorFit> polished = polishAll(posterior, options.threads, starts);
    if (interruptRequested()) break;
    polished.front().evaluations +=
        static_cast<long>(kHybridGenerations) * strategy.lambda * std::ssize(posterior.poses());
    for (PosteriorFit& fit : polished) {
      stop = stop || after_fit(fit);
      best.push_back(std::move(fit));
    }
    keepBest();
  }
  return best.front();
}

}  // namespace simgap
