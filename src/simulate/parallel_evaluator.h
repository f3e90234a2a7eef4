/// \file
/// Individuals x poses spread over threads, each with an arm of its own, with the same result for any thread count.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <optional>

#include "simgap/core/interrupt.h"
#include "simgap/simulate/evaluator.h"

namespace simgap {

/// \tparam Replay  provides `Arm`, `Arm makeArm(const ArmModel&) const` and `PoseOutcome operator()(Arm&, const Pose&)
///                 const`; an Arm is given other models by `setModel`.
template <class Replay>
class ParallelEvaluator : public Evaluator {
 public:
  /// \param poses_per_task  of one thread at a time; few where a pose takes long.
  ParallelEvaluator(Replay replay, int threads, std::size_t poses_per_task)
      : replay_(std::move(replay)),
        arena_(threads > 0 ? threads : tbb::task_arena::automatic),
        poses_per_task_(poses_per_task) {}

  std::vector<PoseOutcome> evaluate(std::span<const ArmModel> models, std::span<const Pose> poses,
                                    AfterInvalid after_invalid) override {
    std::vector<PoseOutcome> outcomes(models.size() * poses.size());
    // A pose may be left out only because of an invalid one before it, so that the first invalid pose, which gives the
    // reason, is the same whatever the threads do.
    std::vector<std::atomic<std::size_t>> first_invalid(models.size());
    for (auto& first : first_invalid) first = poses.size();
    const auto replaySome = [&](const tbb::blocked_range<std::size_t>& tasks) {
      Arm* arm = nullptr;
      for (std::size_t task = tasks.begin(); task < tasks.end(); ++task) {
        const std::size_t k = task / poses.size();
        const std::size_t p = task % poses.size();
        if (!arm || p == 0) arm = &armFor(models[k]);
        if (interruptRequested() || first_invalid[k].load() < p) continue;
        outcomes[task] = replay_(*arm, poses[p]);
        const bool invalid = outcomes[task].status != PoseStatus::kSteady;
        if (invalid && after_invalid == AfterInvalid::kSkipRest) lowerTo(first_invalid[k], p);
      }
    };
    const tbb::blocked_range<std::size_t> all(0, outcomes.size(), poses_per_task_);
    arena_.execute([&] { tbb::parallel_for(all, replaySome, tbb::simple_partitioner()); });
    for (std::size_t task = 0; task < outcomes.size(); ++task) {
      if (task % poses.size() > first_invalid[task / poses.size()]) outcomes[task] = {};
    }
    return outcomes;
  }

 private:
  using Arm = typename Replay::Arm;

  static void lowerTo(std::atomic<std::size_t>& target, std::size_t value) {
    std::size_t seen = target.load();
    while (value < seen && !target.compare_exchange_weak(seen, value)) {
    }
  }

  Arm& armFor(const ArmModel& model) {
    std::optional<Arm>& arm = arms_.local();
    if (arm) {
      arm->setModel(model);
    } else {
      arm.emplace(replay_.makeArm(model));
    }
    return *arm;
  }

  Replay replay_;
  tbb::task_arena arena_;
  std::size_t poses_per_task_;
  tbb::enumerable_thread_specific<std::optional<Arm>> arms_;
};

}  // namespace simgap
