/// \file
/// How often this program has asked for memory, Eigen's requests included; equilibrium_evaluator_test.cpp replaces
/// malloc. The sanitizers have an allocator of their own.
#pragma once

#include <atomic>
#include <cstdlib>

#include "support/sanitized.h"

#if !defined(SIMGAP_SANITIZED) && defined(__GLIBC__)
#define SIMGAP_COUNTS_ALLOCATIONS
#endif

namespace simgap::test {

inline std::atomic<long> allocations{0};

}  // namespace simgap::test
