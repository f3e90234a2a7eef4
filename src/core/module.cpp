#include "simgap/core/module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "simgap/core/error.h"

namespace simgap {
namespace fs = std::filesystem;
namespace {

bool isBelow(const fs::path& given_file, const fs::path& given_folder) {
  std::error_code none;
  const fs::path file = fs::weakly_canonical(given_file, none), folder = fs::weakly_canonical(given_folder, none);
  const auto [in_folder, in_file] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return in_folder == folder.end();
}

}  // namespace

void* moduleEntry(const std::string& name, const std::string& built, const char* entry) {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  const fs::path installed = program.parent_path() / "../lib/simgap" / name;
  const bool from_build = !fs::exists(installed, none) && isBelow(program, fs::path(built).parent_path());
  const std::string file = from_build ? built : installed.string();
  void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const address = handle == nullptr ? nullptr : dlsym(handle, entry);
  if (address == nullptr) throw ConfigError(fmt::format("a part of the program cannot be loaded: {}", dlerror()));
  return address;
}

}  // namespace simgap
