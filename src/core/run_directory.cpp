#include "simgap/core/run_directory.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "simgap/core/error.h"
#include "simgap/version.h"

namespace simgap {
namespace fs = std::filesystem;
namespace {

constexpr char kRunFile[] = "run.json";

[[noreturn]] void failToWrite(const fs::path& file, int error) {
  throw ConfigError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(error)));
}

/// A file of a name nobody else uses, next to the one it will become; removed again unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& target) : target_(target) {
    static std::atomic<unsigned> counter{0};
    do {
      name_ = target.parent_path() / fmt::format(".simgap-{}-{}.tmp", ::getpid(), counter++);
      descriptor_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor_ < 0 && errno == EEXIST);  // left behind by a killed process, or of another machine
    if (descriptor_ < 0) failToWrite(target_, errno);
  }
  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!renamed_) ::unlink(name_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  void write(std::string_view content) {
    while (!content.empty()) {
      const ssize_t written = ::write(descriptor_, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) failToWrite(target_, errno);
      content.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  void becomeTarget() {
    if (::fsync(descriptor_) != 0) failToWrite(target_, errno);
    // Network file systems report a full disk only here.
    if (::close(std::exchange(descriptor_, -1)) != 0) failToWrite(target_, errno);
    if (::rename(name_.c_str(), target_.c_str()) != 0) failToWrite(target_, errno);
    renamed_ = true;
  }

 private:
  const fs::path& target_;
  fs::path name_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

/// Makes a rename survive a power failure. Not every file system can, and the file is complete either way.
void syncFolder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

/// Empties a run directory. run.json goes last, so that an interrupted removal can be taken up again.
void removeContents(const fs::path& directory) {
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (entry.path().filename() != kRunFile) fs::remove_all(entry.path());
  }
  fs::remove(directory / kRunFile);
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

}  // namespace

void writeFileAtomically(const fs::path& file, std::string_view content) {
  writeFileAtomically(file, [&] { return std::exchange(content, {}); });
}

void writeFileAtomically(const fs::path& file, const std::function<std::string_view()>& next_piece) {
  TemporaryFile temporary(file);
  for (std::string_view piece = next_piece(); !piece.empty(); piece = next_piece()) temporary.write(piece);
  temporary.becomeTarget();
  syncFolder(file.has_parent_path() ? file.parent_path() : fs::path("."));
}

std::string readFile(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string content;
  std::error_code none;
  if (fs::is_regular_file(file, none)) content.reserve(fs::file_size(file, none));  // growing would need it twice
  std::array<char, 1 << 16> block;
  // By blocks, not by size: a pipe has none.
  while (stream.read(block.data(), block.size()) || stream.gcount() > 0) {
    content.append(block.data(), static_cast<std::size_t>(stream.gcount()));
  }
  if (!stream.eof()) throw ConfigError(fmt::format("{}: cannot be read", file.string()));
  return content;
}

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

RunDirectory RunDirectory::create(const fs::path& directory, bool force) {
  const std::string name = directory.string();
  try {
    if (fs::exists(directory)) {
      if (!fs::is_directory(directory)) throw ConfigError(fmt::format("{}: exists and is no directory", name));
      if (!force) {
        throw ConfigError(fmt::format("{}: exists; --force replaces it, --resume goes on where it can", name));
      }
      if (!fs::is_empty(directory) && !fs::exists(directory / kRunFile)) {
        throw ConfigError(fmt::format("{}: is not empty and holds no {}, so it is no run and --force leaves it alone",
                                      name, kRunFile));
      }
      removeContents(directory);
    }
    fs::create_directories(directory);
  } catch (const fs::filesystem_error& error) {
    throw ConfigError(fmt::format("{}: cannot be made: {}", name, error.code().message()));
  }
  return RunDirectory(directory);
}

RunDirectory RunDirectory::open(const fs::path& directory) {
  std::error_code ignored;
  if (!fs::is_regular_file(directory / kRunFile, ignored)) {
    throw ConfigError(fmt::format("{}: is no run directory: it holds no {}", directory.string(), kRunFile));
  }
  return RunDirectory(directory);
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
      start_s_(steadySeconds()) {}

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

void RunRecord::write(const RunDirectory& directory, std::string_view status) {
  json_["duration_s"] = steadySeconds() - start_s_;
  json_["status"] = status;
  json_["directory"] = directory.path().string();
  directory.write(kRunFile, json_);
}

}  // namespace simgap
