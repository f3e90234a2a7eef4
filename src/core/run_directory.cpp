#include "simgap/core/run_directory.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/file.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "simgap/core/error.h"
#include "simgap/version.h"

namespace simgap {
namespace fs = std::filesystem;
namespace {

constexpr char kRunFile[] = "run.json";

/// Empties a run directory. run.json goes last, so that an interrupted removal can be taken up again.
void removeContents(const fs::path& directory) {
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (entry.path().filename() != kRunFile) fs::remove_all(entry.path());
  }
  fs::remove(directory / kRunFile);
}

/// What a killed process had not finished writing.
void removeLeftovers(const fs::path& directory) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(directory, ignored)) {
    if (isTemporaryFile(entry.path())) fs::remove(entry.path(), ignored);
  }
}

/// A run, or nothing, or what a process left that was killed before it wrote run.json.
bool holdsNothingButOurs(const fs::path& directory) {
  if (fs::exists(directory / kRunFile)) return true;
  return std::ranges::all_of(fs::directory_iterator(directory),
                             [](const fs::directory_entry& entry) { return isTemporaryFile(entry.path()); });
}

/// The directory for this process alone, until the last copy of what is returned ends, or the process, however it ends.
/// Where a file system has no such locks there is none. \throws ConfigError when another process has it
std::shared_ptr<const int> lockDirectory(const fs::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return nullptr;  // writing will say why
  const auto close = [](const int* opened) {
    ::close(*opened);
    delete opened;
  };
  std::shared_ptr<const int> lock(new int(descriptor), close);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw ConfigError(fmt::format("{}: another simgap is working there", directory.string()));
  }
  return lock;
}

std::string cpuModel() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

Json machine() {
  struct utsname os = {};
  ::uname(&os);
  return {{"cpu", cpuModel()},
          {"cores", std::thread::hardware_concurrency()},
          {"os", fmt::format("{} {} {}", os.sysname, os.release, os.machine)}};
}

double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// When this process began, on the clock of steadySeconds: reading the inputs is part of a run.
double processStart() {
  // Field 22 of /proc/self/stat, in clock ticks since the machine started; field 2, in brackets, may hold spaces.
  const std::string stat = readFile("/proc/self/stat");
  std::istringstream fields(stat.substr(std::min(stat.rfind(')') + 1, stat.size())));
  std::string field;
  for (int i = 3; i <= 22; ++i) fields >> field;
  timespec since_boot = {};
  ::clock_gettime(CLOCK_BOOTTIME, &since_boot);
  const double now = static_cast<double>(since_boot.tv_sec) + 1e-9 * static_cast<double>(since_boot.tv_nsec);
  const double age = now - std::strtod(field.c_str(), nullptr) / static_cast<double>(::sysconf(_SC_CLK_TCK));
  return steadySeconds() - std::max(age, 0.0);
}

}  // namespace

std::string sha256(std::string_view content) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned size = 0;
  if (EVP_Digest(content.data(), content.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available in this OpenSSL");
  }
  std::string hex;
  for (unsigned i = 0; i < size; ++i) hex += fmt::format("{:02x}", digest[i]);
  return hex;
}

std::string toText(const Json& json) {
  // The command line may hold bytes that are no UTF-8; the record of a run must not fail on them.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string utcTime(bool compact) {
  const std::tm utc = fmt::gmtime(std::time(nullptr));
  return compact ? fmt::format("{:%Y%m%dT%H%M%SZ}", utc) : fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", utc);
}

void RunDirectory::write(std::string_view name, std::string_view content) const {
  if (!written_) return;
  if (name.find('/') != std::string_view::npos) fs::create_directory(file(name).parent_path());
  writeFileAtomically(file(name), content);
}

RunDirectory RunDirectory::create(const fs::path& given, bool force) {
  const fs::path directory = given.has_filename() ? given : given.parent_path();  // "out/" is "out"
  const std::string name = directory.string();
  try {
    if (fs::exists(directory) && !fs::is_directory(directory)) {
      throw ConfigError(fmt::format("{}: exists and is no directory", name));
    }
    if (directory.has_parent_path()) fs::create_directories(directory.parent_path());
    const bool made = fs::create_directory(directory);  // by this process, not by another one at the same time
    RunDirectory result(directory, lockDirectory(directory));
    if (made) return result;
    if (!force) {
      throw ConfigError(fmt::format("{}: exists; --force replaces it, --resume goes on where it can", name));
    }
    if (!holdsNothingButOurs(directory)) {
      throw ConfigError(
          fmt::format("{}: is not empty and holds no {}, so it is no run and --force leaves it alone", name, kRunFile));
    }
    removeContents(directory);
    return result;
  } catch (const fs::filesystem_error& error) {
    throw ConfigError(fmt::format("{}: cannot be made: {}", name, error.code().message()));
  }
}

RunDirectory RunDirectory::open(const fs::path& directory) {
  std::error_code ignored;
  if (!fs::is_regular_file(directory / kRunFile, ignored)) {
    throw ConfigError(fmt::format("{}: is no run directory: it holds no {}", directory.string(), kRunFile));
  }
  RunDirectory result(directory, lockDirectory(directory));
  removeLeftovers(directory);
  return result;
}

RunDirectory RunDirectory::unwritten(const fs::path& directory) {
  RunDirectory result(directory, nullptr);
  result.written_ = false;
  return result;
}

fs::path RunDirectory::defaultPath(std::string_view command) {
  const std::string first = fmt::format("runs/{}-{}", command, utcTime(true));
  fs::path path = first;
  for (int i = 2; fs::exists(path); ++i) path = fmt::format("{}-{}", first, i);
  return path;
}

RunRecord::RunRecord(const std::vector<std::string>& argv, std::uint64_t seed, int threads)
    : json_{{"format", "simgap/run/1"},
            {"version", kVersion},
            {"git_hash", kGitHash},
            {"argv", argv},
            {"seed", seed},
            {"threads", threads},
            {"machine", machine()},
            {"start", utcTime()},
            {"duration_s", 0.0},
            {"status", "running"},
            {"inputs", Json::array()}},
      start_s_(processStart()) {}

void RunRecord::addHashedInput(std::string_view role, const fs::path& file, std::string_view hash) {
  json_["inputs"].push_back({{"role", role}, {"file", file.string()}, {"sha256", hash}});
}

void RunRecord::addEarlier(const Json& record) {
  Json earlier = record;
  Json sessions = earlier.value("earlier", Json::array());
  earlier.erase("earlier");
  sessions.push_back(earlier);
  json_["earlier"] = sessions;
}

void RunRecord::end(std::string_view status) {
  json_["duration_s"] = steadySeconds() - start_s_;
  json_["status"] = status;
}

void RunRecord::write(const RunDirectory& directory) const {
  Json json = json_;
  json["directory"] = directory.path().string();
  directory.write(kRunFile, json);
}

}  // namespace simgap
