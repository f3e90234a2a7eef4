/// \file
/// Individuals x poses spread over threads, and over ranks, each with an arm of its own, with the same result for any
/// number of them.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include "simgap/core/interrupt.h"
#include "simgap/core/ranks.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/evaluator.h"

namespace simgap {

/// Poses that are looked at together: few where a pose takes long.
struct PosesAtOnce {
  std::size_t thread;
  std::size_t rank;  ///< what is no more than this no rank hands to another
};

/// \tparam Replay  provides `Arm`, `Arm makeArm(const ArmModel&) const` and `PoseOutcome operator()(Arm&, const Pose&)
///                 const`; an Arm is given other models by `setModel`.
template <class Replay>
class ParallelEvaluator : public Evaluator {
 public:
  ParallelEvaluator(Replay replay, int threads, PosesAtOnce at_once)
      : replay_(std::move(replay)), arena_(threads > 0 ? threads : tbb::task_arena::automatic), at_once_(at_once) {}

  std::vector<PoseOutcome> evaluate(std::span<const ArmModel> models, std::span<const Pose> poses,
                                    AfterInvalid after_invalid) override {
    std::vector<PoseOutcome> outcomes(models.size() * poses.size());
    Job job{models, poses, after_invalid == AfterInvalid::kSkipRest,
            std::vector<std::atomic<std::size_t>>(models.size())};
    for (auto& first : job.first_invalid) first = poses.size();
    const bool ranked = rankCount() > 1 && outcomes.size() > at_once_.rank;
    arena_.execute([&] { ranked ? replayOnRanks(job, outcomes) : replayHere(job, outcomes); });
    for (std::size_t task = 0; task < outcomes.size(); ++task) {
      if (job.pose(task) > job.first_invalid[job.model(task)]) outcomes[task] = {};
    }
    return outcomes;
  }

 private:
  using Arm = typename Replay::Arm;

  /// Task k * poses + p: pose p of model k.
  struct Job {
    std::span<const ArmModel> models;
    std::span<const Pose> poses;
    bool skip_rest;
    /// A pose may be left out only because of an invalid one before it, so that the first invalid pose, which gives
    /// the reason, is the same whatever the threads do.
    std::vector<std::atomic<std::size_t>> first_invalid;

    std::size_t model(std::size_t task) const { return task / poses.size(); }
    std::size_t pose(std::size_t task) const { return task % poses.size(); }
    bool needed(std::size_t task) const { return pose(task) <= first_invalid[model(task)].load(); }
    void note(std::size_t task, const PoseOutcome& outcome) {
      if (!skip_rest || outcome.status == PoseStatus::kSteady) return;
      std::atomic<std::size_t>& first = first_invalid[model(task)];
      std::size_t seen = first.load();
      while (pose(task) < seen && !first.compare_exchange_weak(seen, pose(task))) {
      }
    }
  };

  /// Replays tasks begin … end - 1 and gives each outcome to `put(task, outcome)`.
  template <class Put>
  void replaySome(Job& job, std::size_t begin, std::size_t end, const Put& put) {
    Arm* arm = nullptr;
    for (std::size_t task = begin; task < end; ++task) {
      if (!arm || job.pose(task) == 0) arm = &armFor(job.models[job.model(task)]);
      if (interruptRequested() || !job.needed(task)) continue;
      PoseOutcome outcome = replay_(*arm, job.poses[job.pose(task)]);
      job.note(task, outcome);
      put(task, std::move(outcome));
    }
  }

  void replayHere(Job& job, std::vector<PoseOutcome>& outcomes) {
    const tbb::blocked_range<std::size_t> all(0, outcomes.size(), at_once_.thread);
    const auto put = [&](std::size_t task, PoseOutcome&& outcome) { outcomes[task] = std::move(outcome); };
    tbb::parallel_for(
        all, [&](const auto& tasks) { replaySome(job, tasks.begin(), tasks.end(), put); }, tbb::simple_partitioner());
  }

  void replayOnRanks(Job& job, std::vector<PoseOutcome>& outcomes) {
    const std::size_t size = at_once_.rank;
    const auto end = [&](std::size_t group) { return std::min((group + 1) * size, outcomes.size()); };
    RankedTasks groups;
    groups.count = (outcomes.size() + size - 1) / size;
    groups.compute = [&](std::size_t group) {
      Bytes bytes;
      replaySome(job, group * size, end(group), [&](std::size_t task, PoseOutcome&& outcome) {
        pack(bytes, task);
        pack(bytes, outcome);
      });
      return bytes;
    };
    groups.place = [&](std::size_t, std::string_view bytes) {
      for (BytesReader from{bytes}; !from.left.empty();) {
        std::size_t task = 0;
        unpack(from, task);
        unpack(from, outcomes[task]);
        job.note(task, outcomes[task]);
      }
    };
    groups.needed = [&](std::size_t group) {
      for (std::size_t task = group * size; task < end(group); ++task) {
        if (job.needed(task)) return true;
      }
      return false;
    };
    groups.digest = digestOf(job);
    doOnRanks(groups);
  }

  /// Of every number of the models: where ranks calculate differently, searches part here.
  static Bytes digestOf(const Job& job) {
    Bytes numbers;
    for (ArmModel model : job.models) {
      visitParameters(model, [&](const ParameterPath&, const ParameterKind&, double& value) { pack(numbers, value); });
    }
    Bytes digest;
    pack(digest, std::hash<Bytes>{}(numbers));
    return digest;
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
  PosesAtOnce at_once_;
  tbb::enumerable_thread_specific<std::optional<Arm>> arms_;
};

}  // namespace simgap
