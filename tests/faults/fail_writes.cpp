// Preloaded into simgap (LD_PRELOAD): one call that changes the disk fails, as on a disk that is full or broken.
//   FAIL_UNDER   only calls on what stands below this folder count
//   FAIL_AT      the call that fails, counted from 1; 0: none
//   FAIL_ON      "once", or "forever": that call and all after it
//   FAIL_COUNT   a file into which the number of calls is written in the end
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

const char* setting(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::atomic<long> calls{0};

/// Whether this call, the next one, is to fail.
bool fails() {
  static const long at = std::atol(setting("FAIL_AT"));
  static const bool forever = std::strcmp(setting("FAIL_ON"), "forever") == 0;
  const long call = ++calls;
  const bool now = at > 0 && (forever ? call >= at : call == at);
  if (now) errno = ENOSPC;
  return now;
}

bool isOurs(const char* path) {
  static const char* const under = setting("FAIL_UNDER");
  return *under != '\0' && std::strncmp(path, under, std::strlen(under)) == 0;
}

bool isOurs(int descriptor) {
  char link[64], path[4096];
  std::snprintf(link, sizeof(link), "/proc/self/fd/%d", descriptor);
  const ssize_t length = ::readlink(link, path, sizeof(path) - 1);
  if (length < 0) return false;
  path[length] = '\0';
  return isOurs(path);
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

struct Report {
  ~Report() {
    const char* const file = setting("FAIL_COUNT");
    if (*file == '\0') return;
    if (std::FILE* const out = std::fopen(file, "w")) {
      std::fprintf(out, "%ld\n", calls.load());
      std::fclose(out);
    }
  }
} report;

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* bytes, size_t count) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  if (isOurs(descriptor) && fails()) return -1;
  return real(descriptor, bytes, count);
}

int fsync(int descriptor) {
  static const auto real = next<int (*)(int)>("fsync");
  if (isOurs(descriptor) && fails()) return -1;
  return real(descriptor);
}

int close(int descriptor) {
  static const auto real = next<int (*)(int)>("close");
  const bool failing = isOurs(descriptor) && fails();
  const int error = errno;
  const int result = real(descriptor);  // a failing close has closed
  if (!failing) return result;
  errno = error;
  return -1;
}

int rename(const char* from, const char* to) {
  static const auto real = next<int (*)(const char*, const char*)>("rename");
  if (isOurs(to) && fails()) return -1;
  return real(from, to);
}

int mkdir(const char* path, mode_t mode) {
  static const auto real = next<int (*)(const char*, mode_t)>("mkdir");
  if (isOurs(path) && fails()) return -1;
  return real(path, mode);
}

int open(const char* path, int flags, ...) {
  static const auto real = next<int (*)(const char*, int, ...)>("open");
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  if ((flags & O_CREAT) != 0 && isOurs(path) && fails()) return -1;
  return real(path, flags, mode);
}

}  // extern "C"
