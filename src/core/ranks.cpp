#include "simgap/core/ranks.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "rank_exchange.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/module.h"

namespace simgap {
namespace {

void doOnFirstRank(const RankedTasks& tasks) {
  Bytes call = beginWith(RankCall::kTasks);
  pack(call, tasks.count);
  pack(call, tasks.digest);
  team().broadcast(std::move(call));
  FirstExchange exchange(tasks);
  try {
    exchange.run();
  } catch (...) {
    if (!team().ended) team().callToEnd();
    throw;
  }
  if (team().ended) return;
  if (interruptRequested()) return team().callToEnd();  // results are missing
  Bytes all = beginWith(RankCall::kTasks);
  for (std::size_t task = 0; task < tasks.count; ++task) {
    const std::optional<Bytes>& result = exchange.results()[task];
    pack(all, result.has_value());
    if (result) pack(all, *result);
  }
  team().broadcast(std::move(all));
}

/// What the first rank calls to, without its first word. \throws RanksEnded
BytesReader called(const Bytes& call, RankCall expected) {
  BytesReader from{call};
  RankCall kind{};
  unpack(from, kind);
  if (kind == RankCall::kEnd) goAsOther();
  if (kind != expected) failOnRank("does something else than the first rank", ExitCode::kInternal);
  return from;
}

void doAsOther(const RankedTasks& tasks) {
  OtherExchange exchange(tasks);
  try {
    exchange.run();
  } catch (const std::exception& failure) {
    if (exchange.stopped()) goAsOther();
    const auto* const error = dynamic_cast<const Error*>(&failure);
    failOnRank(failure.what(), error ? error->code() : ExitCode::kInternal);
  }
  if (exchange.stopped()) goAsOther();
}

void doOnOtherRank(const RankedTasks& tasks) {
  const Bytes call = team().broadcast();
  BytesReader from = called(call, RankCall::kTasks);
  std::size_t count = 0;
  std::string digest;
  unpack(from, count);
  unpack(from, digest);
  if (count != tasks.count || digest != tasks.digest) {
    failOnRank("calculates differently from the first rank; ranks have to run on machines of one kind",
               ExitCode::kUsage);
  }
  doAsOther(tasks);
  const Bytes all = team().broadcast();
  BytesReader results = called(all, RankCall::kTasks);
  for (std::size_t task = 0; task < tasks.count; ++task) {
    bool has = false;
    unpack(results, has);
    if (!has) continue;
    Bytes result;
    unpack(results, result);
    tasks.place(task, result);
  }
}

void fallSilent() {
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing, stream);
  ::close(nothing);
  signal(SIGINT, SIG_IGN);
  signal(SIGTERM, SIG_IGN);
}

/// Waits until all other ranks have said farewell. \returns false: one is dead, or hangs
bool allHaveLeft() {
  constexpr std::chrono::seconds kLongest{10};
  int there = team().count - 1;
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + kLongest;
  for (Patience patience; there > 0 && Clock::now() < until;) {
    if (const auto message = team().receive()) {
      there -= message->bytes.front() == static_cast<char>(RankWord::kFarewell);
    } else {
      std::this_thread::sleep_for(patience.next());
    }
  }
  return there == 0;
}

/// Goes when the first rank does; where that still counts on this one, it is told why it should not.
void leaveAsOther(ExitCode code, std::string_view failure) {
  const std::string_view why = failure.empty() ? "was at its end before the first rank" : failure;
  try {
    while (!team().ended) {
      const Bytes call = team().broadcast();
      if (call.front() == static_cast<char>(RankCall::kShare)) continue;
      if (call.front() == static_cast<char>(RankCall::kTasks)) failOnRank(why, code);
      goAsOther();
    }
  } catch (const RanksEnded&) {
  }
}

}  // namespace

void joinRanks() {
  const char* const size = std::getenv("OMPI_COMM_WORLD_SIZE");
  const bool together = size ? std::string_view(size) != "1" : std::getenv("PMIX_RANK") != nullptr;
  if (!together) return;
  if (dlopen("libmpi.so.40", RTLD_NOW | RTLD_GLOBAL) == nullptr) {
    throw ConfigError(fmt::format("Open MPI 4 cannot be loaded: {}", dlerror()));
  }
  using Module = RankChannel* (*)();
  RankTeam& us = team();
  us.channel = reinterpret_cast<Module>(moduleEntry("mpi", "simgapMpiModule"))();
  us.rank = us.channel->rank();
  us.count = us.channel->count();
  if (us.rank > 0) fallSilent();
}

std::size_t rankCount() noexcept {
  const RankTeam& us = team();
  return (us.ended && us.rank == 0) || us.at_work ? 1 : static_cast<std::size_t>(us.count);
}

bool isFirstRank() noexcept { return team().rank == 0; }

void doOnRanks(const RankedTasks& tasks) {
  if (team().ended && team().rank > 0) goAsOther();
  struct AtWork {
    AtWork() { team().at_work = true; }
    ~AtWork() { team().at_work = false; }
  } const at_work;
  ++team().lists;
  team().rank == 0 ? doOnFirstRank(tasks) : doOnOtherRank(tasks);
}

Bytes shareFromFirstRank(const std::function<Bytes()>& read) {
  if (rankCount() == 1) return read();
  if (team().rank > 0) {
    if (team().ended) goAsOther();
    const Bytes call = team().broadcast();
    return Bytes(called(call, RankCall::kShare).left);
  }
  const Bytes shared = read();
  team().broadcast(beginWith(RankCall::kShare) + shared);
  return shared;
}

int leaveRanks(int code, std::string_view failure) {
  RankTeam& us = team();
  if (us.count == 1) return code;
  if (us.rank > 0) {
    leaveAsOther(static_cast<ExitCode>(code), failure);
    team().send(0, beginWith(RankWord::kFarewell));
    us.channel->end();
    return 0;
  }
  spdlog::debug("ranks: {}; lists of tasks {}, messages {}, bytes {}", us.count, us.lists, us.messages, us.bytes);
  if (!us.ended) team().callToEnd();
  if (us.unheard || !allHaveLeft()) _exit(code);  // mpirun ends what is left
  us.channel->end();
  return code;
}

}  // namespace simgap
