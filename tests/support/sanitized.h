/// \file
/// Whether this program was built under the address sanitizer, which has an allocator and an address space of its own.
#pragma once

#if defined(__SANITIZE_ADDRESS__)  // how gcc says it
#define SIMGAP_SANITIZED
#elif defined(__has_feature)  // and clang
#if __has_feature(address_sanitizer)
#define SIMGAP_SANITIZED
#endif
#endif
