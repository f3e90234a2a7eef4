#include "simgap/core/module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>

#include "simgap/core/error.h"

namespace simgap {

void* moduleEntry(const std::string& name, const std::string& built, const char* entry) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  const fs::path installed = program.parent_path() / "../lib/simgap" / name;
  const std::string file = fs::exists(installed, none) ? installed.string() : built;
  void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const address = handle == nullptr ? nullptr : dlsym(handle, entry);
  if (address == nullptr) throw ConfigError(fmt::format("a part of the program cannot be loaded: {}", dlerror()));
  return address;
}

}  // namespace simgap
