#include "simgap/core/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>

#include "simgap/core/error.h"

namespace simgap {
namespace {

// A handler may touch nothing but lock-free atomics, and other threads read the flag.
std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void onStopSignal(int signal) {
  const bool again = requested.exchange(true, std::memory_order_relaxed);
  if (again && signal == SIGINT) _exit(static_cast<int>(ExitCode::kInterrupted));
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

}  // namespace simgap
