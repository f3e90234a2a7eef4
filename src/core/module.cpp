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

void* moduleEntry(const std::string& name, const char* entry) {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  const std::string library = fmt::format("libsimgap_{}.so", name);
  const fs::path installed = program.parent_path() / "../lib/simgap" / library;
  const bool from_build = !fs::exists(installed, none) && isBelow(program, SIMGAP_BUILD_FOLDER);
  const fs::path file = from_build ? fs::path(SIMGAP_BUILD_FOLDER) / library : installed;
  void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const address = handle == nullptr ? nullptr : dlsym(handle, entry);
  if (address == nullptr) throw ConfigError(fmt::format("a part of the program cannot be loaded: {}", dlerror()));
  return address;
}

}  // namespace simgap
