/// \file
/// One run on many processes: `mpirun -n N simgap …`. Every process (rank) is the same program on the same input and
/// takes the same way through it; what is a list of independent tasks each does a part of, and all get all results. The
/// first rank alone reads the user's files, writes results and speaks; without mpirun it is the only one.
///
/// Tasks are handed out as ranks ask for them, and results go where their index says: a run ends bit-identically on any
/// number of ranks and threads.
#pragma once

#include <tbb/parallel_for.h>

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "simgap/core/bytes.h"
#include "simgap/core/error.h"

namespace simgap {

/// A list of independent tasks.
struct RankedTasks {
  std::size_t count = 0;
  /// The result of a task; from several threads at once.
  std::function<Bytes(std::size_t task)> compute;
  /// Takes a result, on every rank, one at a time.
  std::function<void(std::size_t task, std::string_view result)> place;
  /// Asked on the first rank before a task is handed out; one that is not needed is placed nowhere. Empty: all are.
  std::function<bool(std::size_t task)> needed = {};
  /// Of what the tasks work on: where ranks differ in it they have come apart, because their machines calculate
  /// differently, and the run ends.
  std::string digest = {};
  bool one_by_one = false;  ///< each rank does one task at a time: the tasks use all threads themselves
};

/// Joins the other ranks, when mpirun (or srun) started this process. All but the first then ignore interrupts and
/// print nothing. \throws ConfigError: Open MPI cannot be loaded
void joinRanks();
std::size_t rankCount() noexcept;  ///< 1 without mpirun
bool isFirstRank() noexcept;

/// Does the tasks on the threads of the calling task arena, on all ranks. After an interrupt some are missing.
/// \throws what a task throws, on the first rank; RanksEnded on another one when the first has ended the run
void doOnRanks(const RankedTasks& tasks);

/// What `read` gives on the first rank, which alone calls it.
Bytes shareFromFirstRank(const std::function<Bytes()>& read);

/// The end, for main: lets the other ranks go. \param failure  why this rank failed, or empty
/// \returns the exit code: of the others 0, so that mpirun passes on the first one's
int leaveRanks(int code, std::string_view failure);

/// Another rank's way out: the first one has ended, or failed.
struct RanksEnded : InterruptedError {
  RanksEnded() : InterruptedError("the first rank has ended the run") {}
};

/// place(i, compute(i)) for all i, on all threads of all ranks; `compute` looks for interrupts itself. Without other
/// ranks `place` is called from several threads at once, with others one at a time, on every rank.
/// \param one_by_one, digest  as RankedTasks
template <class Compute, class Place>
void shareOnRanks(std::size_t count, const Compute& compute, const Place& place, bool one_by_one = false,
                  Bytes digest = {}) {
  const auto one = [&](std::size_t i) { place(i, compute(i)); };
  if (rankCount() == 1 && one_by_one) {
    for (std::size_t i = 0; i < count; ++i) one(i);
    return;
  }
  if (rankCount() == 1) return tbb::parallel_for(std::size_t{0}, count, one);
  RankedTasks tasks;
  tasks.count = count;
  tasks.one_by_one = one_by_one;
  tasks.digest = std::move(digest);
  tasks.compute = [&](std::size_t i) {
    Bytes bytes;
    pack(bytes, compute(i));
    return bytes;
  };
  tasks.place = [&](std::size_t i, std::string_view bytes) {
    std::decay_t<decltype(compute(i))> result;
    BytesReader reader{bytes};
    unpack(reader, result);
    place(i, std::move(result));
  };
  doOnRanks(tasks);
}

/// results[i] = compute(i) for all i, likewise.
template <class Result, class Compute>
void computeOnRanks(std::span<Result> results, const Compute& compute, bool one_by_one = false, Bytes digest = {}) {
  const auto place = [&](std::size_t i, Result&& result) { results[i] = std::move(result); };
  shareOnRanks(results.size(), compute, place, one_by_one, std::move(digest));
}

}  // namespace simgap
