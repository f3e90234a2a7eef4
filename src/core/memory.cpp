#include "simgap/core/memory.h"

#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>

#include "simgap/core/error.h"

namespace simgap {
namespace {

std::atomic<bool> memory_was_refused{false};
std::terminate_handler terminate_before = nullptr;

/// As without a handler. What is thrown cannot be asked for later: GCC forgets it where it ends an inlined destructor.
[[noreturn]] void onNoMemory() {
  memory_was_refused.store(true, std::memory_order_relaxed);
  throw std::bad_alloc();
}

/// Takes no memory itself.
[[noreturn]] void onTerminate() {
  if (!memory_was_refused.load(std::memory_order_relaxed)) {
    if (terminate_before != nullptr) terminate_before();
    std::abort();
  }
  for (const char* part : {"simgap: ", kNoMemory, "\n"}) {
    if (::write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
  }
  ::_exit(static_cast<int>(ExitCode::kUsage));
}

}  // namespace

void installNoMemoryHandler() {
  std::set_new_handler(onNoMemory);
  terminate_before = std::set_terminate(onTerminate);
}

}  // namespace simgap
