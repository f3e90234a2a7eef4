#include "simgap/core/interrupt.h"

#include <poll.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>

#include "simgap/core/error.h"

namespace simgap {
namespace {

// A handler may touch nothing but lock-free atomics, and other threads read the flag.
std::atomic<bool> requested{false};
std::atomic<std::int64_t> first_request_ms{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);

extern "C" void onStopSignal(int /*signal*/) {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t milliseconds = now.tv_sec * std::int64_t{1000} + now.tv_nsec / 1'000'000;
  // `timeout` and some terminals send one wish to stop twice, to the process and to its group.
  constexpr std::int64_t kSameWish = 500;
  const std::int64_t before = first_request_ms.load(std::memory_order_relaxed);
  if (before > 0 && milliseconds - before <= kSameWish) return;
  first_request_ms.store(milliseconds, std::memory_order_relaxed);
  if (requested.exchange(true, std::memory_order_relaxed)) _exit(static_cast<int>(ExitCode::kInterrupted));
}

}  // namespace

void installInterruptHandlers() {
  struct sigaction action = {};
  action.sa_handler = onStopSignal;
  action.sa_flags = SA_RESTART;  // libraries that write files need not expect EINTR
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interruptRequested() noexcept { return requested.load(std::memory_order_relaxed); }

void requestInterrupt() noexcept { requested.store(true, std::memory_order_relaxed); }
void interruptAnswered() noexcept { requested.store(false, std::memory_order_relaxed); }

void stopIfInterrupted() {
  if (interruptRequested())
    throw InterruptedError("interrupted; nothing to resume: run the command again, with --force if it writes a folder");
}

void waitForBytes(int descriptor) {
  constexpr int kLookEvery = 200;  // [ms] a signal just before poll, which it interrupts, would be waited for otherwise
  pollfd waited{descriptor, POLLIN, 0};
  do {
    stopIfInterrupted();
  } while (::poll(&waited, 1, kLookEvery) <= 0);
}

}  // namespace simgap
