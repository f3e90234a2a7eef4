#include "simgap/fit/poses/posterior_search.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>

#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"
#include "simgap/core/ranks.h"

namespace simgap {
namespace {

constexpr std::uint32_t kStartPurpose = 3, kGroupPurpose = 7;  // 1 and 2 are the evolution strategy's

tbb::task_arena makeArena(int threads) { return tbb::task_arena(threads > 0 ? threads : tbb::task_arena::automatic); }

/// Calls action(posterior, i) for i = 0 … count - 1, each thread with a posterior of its own.
template <class Action>
void inParallel(const PosePosterior& posterior, int threads, std::size_t count, const Action& action) {
  tbb::enumerable_thread_specific<PosePosterior> own(posterior);
  makeArena(threads).execute([&] {
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

/// One of every k poses, so that some hundred are left: of more, the way to the minimum learns little. Drawn, not every
/// k-th: of poses that are visited again and again in one order, that could be always the same few.
std::vector<Pose> someOf(std::span<const Pose> poses) {
  constexpr std::size_t kEnoughPoses = 100;
  const std::size_t stride = (poses.size() + kEnoughPoses - 1) / kEnoughPoses;
  const CounterRandom random(0);
  std::vector<Pose> some;
  for (std::size_t p = 0; p < poses.size(); p += stride) {
    const std::span<const Pose> group = poses.subspan(p, std::min(stride, poses.size() - p));
    const double drawn = random.uniform({0, static_cast<std::uint32_t>(p), 0, kGroupPurpose});
    some.push_back(group[static_cast<std::size_t>(drawn * static_cast<double>(group.size()))]);
  }
  return some;
}

/// Some of the poses, and where the first descent ended on all of them and on these.
struct Coarse {
  PosePosterior posterior;
  bool all;  ///< there are so few that these are all
  Eigen::VectorXd z_all, z_some;
};

/// On the way to somewhere else: of an objective of a hundred, the last hundredth is not worth its steps.
PosteriorFit descendRoughly(PosePosterior& posterior, const Eigen::VectorXd& z) {
  constexpr int kRoughSteps = 60;
  constexpr double kRoughTolerance = 1e-4;
  return descendPosterior(posterior, z, kRoughSteps, kRoughTolerance);
}

/// Near a minimum, or where it ends: from where the torques at the measured poses balance down on some of the poses.
/// \param coarse  its whitening is the descent's, and its own where it has none yet
PosteriorFit approach(const Coarse& coarse, const Eigen::VectorXd& z, bool whiten) {
  PosePosterior own = coarse.posterior;  // balancing changes the whitening
  PosteriorFit fit;
  fit.z = balanceTorques(own, z);
  fit.objective = std::numeric_limits<double>::infinity();  // no minimum
  if (coarse.all) return fit;
  PosePosterior descending = coarse.posterior;
  if (whiten) descending.whiten(fit.z);
  const PosteriorFit found = descendRoughly(descending, fit.z);
  return std::isfinite(found.objective) ? found : fit;
}

/// Which approaches are worth a descent on all poses, and whose fit the others share: those that ended in the same
/// valley.
struct Leaders {
  std::vector<std::size_t> numbers;  ///< of the approaches that go on, in order
  std::vector<std::size_t> of;       ///< shape (approaches): place in `numbers` of each one's leader
};

/// One valley: half-way between two minima the objective is not higher than at the worse one by more than the half that
/// one standard deviation makes. The lowest of a valley leads.
Leaders findLeaders(const Coarse& coarse, const std::vector<PosteriorFit>& near) {
  constexpr double kRise = 0.5;
  PosePosterior posterior = coarse.posterior;
  const auto sameValley = [&](const PosteriorFit& low, const PosteriorFit& high) {
    return std::isfinite(high.objective) && posterior.objective(0.5 * (low.z + high.z)) <= high.objective + kRise;
  };
  std::vector<std::size_t> order(near.size()), leader(near.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return near[i].objective; });
  Leaders leaders;
  for (const std::size_t i : order) {
    const auto found =
        std::ranges::find_if(leaders.numbers, [&](std::size_t l) { return sameValley(near[l], near[i]); });
    leader[i] = found == leaders.numbers.end() ? i : *found;
    if (leader[i] == i) leaders.numbers.push_back(i);
  }
  std::ranges::sort(leaders.numbers);
  for (const std::size_t l : leader) {
    leaders.of.push_back(static_cast<std::size_t>(std::ranges::find(leaders.numbers, l) - leaders.numbers.begin()));
  }
  return leaders;
}

/// A minimum on some of the poses, moved as the first one moved when all were asked, if that is nearer.
Eigen::VectorXd movedAsTheFirst(PosePosterior& posterior, const Coarse& coarse, const Eigen::VectorXd& z) {
  Eigen::VectorXd moved = z + coarse.z_all - coarse.z_some;
  const ScaledParameters& parameters = posterior.parameters();
  for (Eigen::Index i = 0; i < z.size(); ++i) moved[i] = std::clamp(moved[i], parameters.lower(i), parameters.upper(i));
  return posterior.objective(moved) < posterior.objective(z) ? moved : z;
}

/// From the approach; from z itself where an arm like that has a pose without an equilibrium.
PosteriorFit descendFrom(PosePosterior& posterior, const Coarse& coarse, const PosteriorFit& near,
                         const Eigen::VectorXd& z) {
  PosteriorFit fit = descendPosterior(posterior, coarse.all ? near.z : movedAsTheFirst(posterior, coarse, near.z));
  long evaluations = near.evaluations + (coarse.all ? 0 : 2 * std::ssize(posterior.poses()));
  if (std::isinf(fit.objective)) {
    evaluations += fit.evaluations;
    fit = descendPosterior(posterior, z);
  }
  fit.evaluations += evaluations;
  return fit;
}

/// The finished descents of a search: those of an earlier session first, then new ones, which are made several at once
/// and passed on in their order.
class Descents {
 public:
  Descents(PosePosterior& posterior, const PosteriorSearchOptions& options, SearchJournal& journal,
           const AfterFit& after_fit)
      : posterior_(posterior), options_(options), journal_(journal), after_fit_(after_fit) {}

  /// Makes `count` more by descend(posterior, i), i = 0 … count - 1. \returns false where the search ends
  /// \param from  what they begin from, the same on all ranks
  template <class Descend>
  bool add(std::size_t count, const std::vector<Eigen::VectorXd>& from, const Descend& descend) {
    const std::size_t first = passed_on_;
    while (passed_on_ < first + count) {
      if (passed_on_ == journal_.fits.size()) makeSome(passed_on_ - first, count, from, descend);
      if (interruptRequested()) return false;
      while (passed_on_ < std::min(first + count, journal_.fits.size())) {
        if (after_fit_(journal_.fits[passed_on_++])) return false;
      }
    }
    return true;
  }
  /// One more that is made already. \returns false where the search ends
  bool addMade(PosteriorFit fit) {
    if (passed_on_ == journal_.fits.size()) journal_.fits.push_back(std::move(fit));
    return !after_fit_(journal_.fits[passed_on_++]);
  }
  /// make(posterior, i) for i = 0 … count - 1, of which nothing is kept in the journal. After an interrupt some are
  /// missing.
  template <class Make>
  std::vector<PosteriorFit> make(std::size_t count, const std::vector<Eigen::VectorXd>& from, const Make& makeOne) {
    std::vector<PosteriorFit> made(count);
    if (options_.on_ranks) {
      tbb::enumerable_thread_specific<PosePosterior> own(posterior_);
      makeArena(options_.threads).execute([&] {
        const auto unlessInterrupted = [&](std::size_t i) {
          return interruptRequested() ? PosteriorFit() : makeOne(own.local(), i);
        };
        Bytes digest;
        pack(digest, from);
        computeOnRanks(std::span(made), unlessInterrupted, /*one_by_one=*/false, std::move(digest));
      });
    } else {
      inParallel(posterior_, options_.threads, count,
                 [&](PosePosterior& own, std::size_t i) { made[i] = makeOne(own, i); });
    }
    return made;
  }
  std::vector<PosteriorFit> passedOn() const {
    return {journal_.fits.begin(), journal_.fits.begin() + static_cast<std::ptrdiff_t>(passed_on_)};
  }

 private:
  template <class Descend>
  void makeSome(std::size_t begin, std::size_t end, const std::vector<Eigen::VectorXd>& from, const Descend& descend) {
    const std::size_t at_once = 8 * (options_.on_ranks ? rankCount() : 1);  // what a kill can cost
    std::vector<PosteriorFit> made = make(std::min(at_once, end - begin), from,
                                          [&](PosePosterior& own, std::size_t i) { return descend(own, begin + i); });
    if (interruptRequested()) return;  // some are not finished
    std::move(made.begin(), made.end(), std::back_inserter(journal_.fits));
  }

  PosePosterior& posterior_;
  const PosteriorSearchOptions& options_;
  SearchJournal& journal_;
  const AfterFit& after_fit_;
  std::size_t passed_on_ = 0;
};

/// Where to whiten: the first start's solution, on many poses a rough one. \returns false after an interrupt
bool whitenAtFirst(const PosePosterior& posterior, const Coarse& coarse, const Eigen::VectorXd& start,
                   SearchJournal& journal, long& evaluations) {
  const PosteriorFit near = approach(coarse, start, /*whiten=*/true);
  PosePosterior own = posterior;
  own.whiten(near.z);
  const PosteriorFit first = coarse.all ? descendPosterior(own, near.z) : descendRoughly(own, near.z);
  if (interruptRequested()) return false;
  evaluations = near.evaluations + first.evaluations;
  journal.whitened_at = first.z;
  return true;
}

/// The descents from every start. \returns false where the search ends
bool descendFromStarts(PosePosterior& posterior, const PosteriorSearchOptions& options, SearchJournal& journal,
                       Descents& descents) {
  const std::vector<Pose> some = someOf(posterior.poses());
  Coarse coarse{PosePosterior(posterior, some), some.size() == posterior.poses().size(), {}, {}};
  const auto start = [&](std::size_t i) { return drawStart(posterior.parameters(), options.seed, i); };
  long cost = 0;
  if (journal.fits.empty() && !whitenAtFirst(posterior, coarse, start(0), journal, cost)) return false;
  posterior.whiten(journal.whitened_at);
  coarse.posterior.whiten(journal.whitened_at);
  if (!coarse.all) {
    const PosteriorFit on_some = descendRoughly(coarse.posterior, journal.whitened_at);
    coarse.z_some = on_some.z;
    cost += on_some.evaluations;
  }
  const std::vector<Eigen::VectorXd> from{journal.whitened_at};
  const bool go_on = descents.add(1, from, [&](PosePosterior& own, std::size_t) {
    PosteriorFit fit = descendPosterior(own, journal.whitened_at);
    if (std::isinf(fit.objective)) fit = descendPosterior(own, start(0));
    fit.evaluations += cost;
    return fit;
  });
  if (!go_on) return false;
  coarse.z_all = journal.fits.front().z;

  const auto others = static_cast<std::size_t>(std::max(0, options.starts - 1));
  const std::vector<PosteriorFit> near = descents.make(
      others, from, [&](PosePosterior&, std::size_t i) { return approach(coarse, start(i + 1), /*whiten=*/false); });
  if (interruptRequested()) return false;
  const Leaders leaders = findLeaders(coarse, near);
  std::vector<Eigen::VectorXd> led_from;
  for (const std::size_t i : leaders.numbers) led_from.push_back(near[i].z);
  const bool led = descents.add(leaders.numbers.size(), led_from, [&](PosePosterior& own, std::size_t k) {
    const std::size_t i = leaders.numbers[k];
    return descendFrom(own, coarse, near[i], start(i + 1));
  });
  if (!led) return false;
  for (std::size_t i = 0; i < others; ++i) {
    if (leaders.numbers[leaders.of[i]] == i) continue;
    PosteriorFit shared = journal.fits[1 + leaders.of[i]];
    shared.iterations = 0;
    shared.evaluations = near[i].evaluations;
    if (!descents.addMade(std::move(shared))) return false;
  }
  return true;
}

/// A few generations of the evolution strategy around the best fits. \returns the parents they end with
std::vector<Eigen::VectorXd> explore(const PosePosterior& posterior, int threads, std::span<const PosteriorFit> best,
                                     const EvolutionStrategyOptions& options) {
  std::vector<ObjectParameter> space;
  for (Eigen::Index i = 0; i < posterior.parameters().size(); ++i) {
    space.push_back({0.0, kHybridStep, posterior.parameters().lower(i), posterior.parameters().upper(i)});
  }
  EvolutionStrategyState state;
  for (const PosteriorFit& fit : best) {
    state.parents.push_back(
        {{fit.z.begin(), fit.z.end()}, std::vector<double>(space.size(), kHybridStep), fit.objective});
  }
  state.best = state.parents.front();
  EvolutionStrategy explorer(space, options, state);
  while (!explorer.stopped() && !interruptRequested()) {
    const std::vector<Individual>& offspring = explorer.ask();
    std::vector<double> objectives(offspring.size());
    inParallel(posterior, threads, offspring.size(), [&](PosePosterior& own, std::size_t k) {
      objectives[k] = own.objective(Eigen::Map<const Eigen::VectorXd>(offspring[k].y.data(), std::ssize(space)));
    });
    explorer.tell(objectives);
  }
  std::vector<Eigen::VectorXd> parents;
  for (const Individual& parent : explorer.state().parents) {
    parents.emplace_back(Eigen::Map<const Eigen::VectorXd>(parent.y.data(), std::ssize(space)));
  }
  return parents;
}

/// The `count` best, best first.
std::vector<PosteriorFit> bestOf(std::vector<PosteriorFit> fits, int count) {
  std::stable_sort(fits.begin(), fits.end(),
                   [](const PosteriorFit& a, const PosteriorFit& b) { return a.objective < b.objective; });
  if (std::ssize(fits) > count) fits.resize(count);
  return fits;
}

}  // namespace

std::vector<PosteriorFit> searchPosterior(PosePosterior& posterior, const PosteriorSearchOptions& options,
                                          SearchJournal& journal, const AfterFit& after_fit) {
  Descents descents(posterior, options, journal, after_fit);
  descendFromStarts(posterior, options, journal, descents);
  return descents.passedOn();
}

std::vector<PosteriorFit> searchPosterior(PosePosterior& posterior, const PosteriorSearchOptions& options) {
  SearchJournal journal;
  return searchPosterior(posterior, options, journal, [](const PosteriorFit&) { return false; });
}

void searchHybrid(PosePosterior& posterior, const PosteriorSearchOptions& options,
                  const EvolutionStrategyOptions& strategy, SearchJournal& journal, const AfterFit& after_fit) {
  Descents descents(posterior, options, journal, after_fit);
  bool go_on = descendFromStarts(posterior, options, journal, descents);
  EvolutionStrategyOptions exploration = strategy;
  exploration.generations = kHybridGenerations;
  for (int round = 1; round <= kHybridRounds && go_on; ++round) {
    // Not in the journal: explored again it finds the same, for less than its descents cost.
    exploration.seed = strategy.seed + static_cast<std::uint64_t>(round);
    const std::vector<Eigen::VectorXd> starts =
        explore(posterior, options.threads, bestOf(descents.passedOn(), strategy.mu), exploration);
    if (interruptRequested()) return;
    const long cost = static_cast<long>(kHybridGenerations) * strategy.lambda * std::ssize(posterior.poses());
    go_on = descents.add(starts.size(), starts, [&](PosePosterior& own, std::size_t i) {
      PosteriorFit fit = descendPosterior(own, starts[i]);
      if (i == 0) fit.evaluations += cost;
      return fit;
    });
  }
}

}  // namespace simgap
