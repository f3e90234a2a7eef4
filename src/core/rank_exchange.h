/// \file
/// A list of tasks as one rank does its part of it.
#pragma once

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "rank_team.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/ranks.h"

namespace simgap {

inline std::size_t threadsHere() {
  using Control = tbb::global_control;
  return std::min(static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()),
                  Control::active_value(Control::max_allowed_parallelism));
}

/// The tasks of one list as one rank sees them: threads take them and leave results, a thread of its own exchanges both
/// with the other ranks.
class TaskExchange {
 public:
  explicit TaskExchange(const RankedTasks& tasks) : tasks_(tasks), threads_(tasks.one_by_one ? 1 : threadsHere()) {}
  virtual ~TaskExchange() = default;

  void run() {
    std::jthread messenger([this] { exchange(); });
    tbb::parallel_for(
        std::size_t{0}, threads_, [this](std::size_t) { work(); }, tbb::simple_partitioner());
    messenger.join();
    if (error_) std::rethrow_exception(error_);
  }

 protected:
  /// The next task for a thread of this rank; empty: there is none any more. Waits where one may come.
  virtual std::optional<std::size_t> take() = 0;
  virtual void leave(std::size_t task, Bytes result) = 0;
  /// Talks with other ranks until all is done or ended.
  virtual void exchange() = 0;

  const RankedTasks& tasks_;
  const std::size_t threads_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::exception_ptr error_;

 private:
  void work() try {
    while (const std::optional<std::size_t> task = take()) {
      // Isolated, or a thread that waits in a task could begin to work here once more, and wait for itself.
      tbb::this_task_arena::isolate([&] { leave(*task, tasks_.compute(*task)); });
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    error_ = std::current_exception();
    changed_.notify_all();  // other threads may wait for tasks
  }
};

/// The first rank: hands out what the others ask for, and works itself.
class FirstExchange : public TaskExchange {
 public:
  explicit FirstExchange(const RankedTasks& tasks) : TaskExchange(tasks), results_(tasks.count) {}
  std::vector<std::optional<Bytes>>& results() { return results_; }

 protected:
  std::optional<std::size_t> take() override {
    const std::lock_guard lock(mutex_);
    return error_ || stopped_ || interruptRequested() ? std::nullopt : next();
  }
  void leave(std::size_t task, Bytes result) override {
    const std::lock_guard lock(mutex_);
    keep(task, std::move(result));
  }

  void exchange() override {
    int at_work = team().count - 1;
    for (Patience patience; at_work > 0;) {
      {
        const std::lock_guard lock(mutex_);
        stopped_ = interruptRequested() || error_;
      }
      if (stopped_) return team().stopOthers();
      const auto message = team().receive();
      if (!message) {
        std::this_thread::sleep_for(patience.next());
        continue;
      }
      patience.renew();
      try {
        if (hear(*message)) --at_work;
      } catch (...) {
        const std::lock_guard lock(mutex_);
        error_ = std::current_exception();
      }
    }
  }

 private:
  /// \returns whether it was the rank's last word
  bool hear(const RankMessage& message) {
    BytesReader from{message.bytes};
    RankWord kind{};
    unpack(from, kind);
    if (kind == RankWord::kFailure) fail(message.from, from);
    bool last = false;
    std::size_t wanted = 0, done = 0;
    unpack(from, last);
    unpack(from, wanted);
    unpack(from, done);
    const std::lock_guard lock(mutex_);
    while (done-- > 0) {
      std::size_t task = 0;
      Bytes result;
      unpack(from, task);
      unpack(from, result);
      keep(task, std::move(result));
    }
    if (!last) team().send(message.from, someTasks(wanted));
    return last;
  }

  [[noreturn]] void fail(int rank, BytesReader from) const {
    ExitCode code{};
    std::string sentence;
    unpack(from, code);
    unpack(from, sentence);
    if (code == ExitCode::kNumerics) throw NumericsError(sentence);
    if (code == ExitCode::kBadData) throw DataError(sentence);
    throw ConfigError(fmt::format("rank {}: {}", rank, sentence));
  }

  /// As many as wanted, but fewer towards the end, so that no rank sits on tasks that another one waits for.
  Bytes someTasks(std::size_t wanted) {
    const std::size_t fair = (tasks_.count - next_) / (2 * static_cast<std::size_t>(team().count));
    std::vector<std::size_t> given;
    while (given.size() < std::min(wanted, std::max<std::size_t>(fair, 1))) {
      const auto task = next();
      if (!task) break;
      given.push_back(*task);
    }
    Bytes bytes = beginWith(RankWord::kTasks);
    pack(bytes, given);
    return bytes;
  }

  std::optional<std::size_t> next() {
    while (next_ < tasks_.count && tasks_.needed && !tasks_.needed(next_)) ++next_;
    return next_ < tasks_.count ? std::optional(next_++) : std::nullopt;
  }
  void keep(std::size_t task, Bytes result) {
    tasks_.place(task, result);
    results_[task] = std::move(result);
  }

  std::size_t next_ = 0;
  bool stopped_ = false;
  std::vector<std::optional<Bytes>> results_;
};

/// Another rank: asks for tasks before it runs out of them.
class OtherExchange : public TaskExchange {
 public:
  using TaskExchange::TaskExchange;
  bool stopped() const { return stopped_; }

 protected:
  std::optional<std::size_t> take() override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !queue_.empty() || no_more_ || stopped_ || error_; });
    if (queue_.empty() || stopped_ || error_) return std::nullopt;
    const std::size_t task = queue_.front();
    queue_.pop_front();
    ++computing_;
    return task;
  }
  void leave(std::size_t task, Bytes result) override {
    const std::lock_guard lock(mutex_);
    pack(results_, task);
    pack(results_, result);
    ++done_;
    --computing_;
    changed_.notify_all();
  }

  void exchange() override {
    ask();
    bool asked = true;
    for (Patience patience; true;) {
      if (const auto message = team().receive()) {
        hear(*message);
        asked = false;
        patience.renew();
      }
      std::unique_lock lock(mutex_);
      if (stopped_ || error_) return;
      const bool idle = queue_.empty() && computing_ == 0;
      if (!asked && no_more_ && idle) break;
      const bool news = done_ > 0 && (!no_more_ || idle);
      if (!asked && (news || (!no_more_ && queue_.size() < threads_))) {
        lock.unlock();
        ask();
        asked = true;
        patience.renew();
        continue;
      }
      changed_.wait_for(lock, patience.next());
    }
    say(/*last=*/true, 0);
  }

 private:
  void ask() { say(/*last=*/false, 2 * threads_); }

  void say(bool last, std::size_t ahead) {
    const std::lock_guard lock(mutex_);
    const std::size_t here = queue_.size() + computing_;
    Bytes bytes = beginWith(RankWord::kResults);
    pack(bytes, last);
    pack(bytes, ahead > here ? ahead - here : 0);
    pack(bytes, std::exchange(done_, 0));
    bytes += std::exchange(results_, {});
    team().send(0, std::move(bytes));
  }

  void hear(const RankMessage& message) {
    BytesReader from{message.bytes};
    RankWord kind{};
    unpack(from, kind);
    const std::lock_guard lock(mutex_);
    stopped_ = kind == RankWord::kStop;
    if (stopped_) {
      requestInterrupt();  // what the threads are at is of no use
    } else {
      std::vector<std::size_t> given;
      unpack(from, given);
      no_more_ = given.empty();
      queue_.insert(queue_.end(), given.begin(), given.end());
    }
    changed_.notify_all();
  }

  std::deque<std::size_t> queue_;
  std::size_t computing_ = 0, done_ = 0;
  Bytes results_;  ///< of `done_` tasks
  bool no_more_ = false, stopped_ = false;
};

}  // namespace simgap
