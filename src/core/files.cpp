#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <istream>
#include <streambuf>
#include <utility>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/json_pieces.h"
#include "simgap/core/run_directory.h"

namespace simgap {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kTemporaryBegin = ".simgap-";
constexpr std::string_view kTemporaryEnd = ".tmp";

[[noreturn]] void failToWrite(const fs::path& file, int error) {
  throw ConfigError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(error)));
}

/// A file of a name nobody else uses, next to the one it will become; removed again unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& target) : target_(target) {
    static std::atomic<unsigned> counter{0};
    do {
      name_ = target.parent_path() / fmt::format("{}{}-{}{}", kTemporaryBegin, ::getpid(), counter++, kTemporaryEnd);
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

[[noreturn]] void failToRead(const fs::path& file, int error) {
  if (error == EISDIR) {
    const fs::path model = file / "model.yaml";
    std::error_code none;
    throw ConfigError(fmt::format("{}: found a directory, expected a file{}", file.string(),
                                  fs::exists(model, none) ? ": the model of this run is " + model.string() : ""));
  }
  throw ConfigError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(error)));
}

/// An open file that is closed again.
class ReadDescriptor {
 public:
  /// Does not wait for somebody who writes into a pipe: waitForBytes does, and can be interrupted.
  explicit ReadDescriptor(const fs::path& file)
      : file_(file), descriptor_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
    if (descriptor_ < 0) failToRead(file_, errno);
  }
  ~ReadDescriptor() { ::close(descriptor_); }
  ReadDescriptor(const ReadDescriptor&) = delete;
  ReadDescriptor& operator=(const ReadDescriptor&) = delete;

  /// 0 for what has no size, or none that is known: a pipe, a device.
  std::size_t size() const {
    struct stat status = {};
    const bool known = ::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
    return known ? static_cast<std::size_t>(status.st_size) : 0;
  }

  /// The bytes that were read; 0 at the end.
  std::size_t read(char* bytes, std::size_t count) const {
    while (true) {
      waitForBytes(descriptor_);
      const ssize_t got = ::read(descriptor_, bytes, count);
      if (got >= 0) return static_cast<std::size_t>(got);
      if (errno != EINTR && errno != EAGAIN) failToRead(file_, errno);
    }
  }

 private:
  const fs::path& file_;
  int descriptor_;
};

void refuseMore(const fs::path& file, std::size_t size, std::size_t largest) {
  if (size <= largest) return;
  throw ConfigError(fmt::format("{}: found more than {} MiB, expected less", file.string(), largest >> 20U));
}

/// A file as a stream, of which memory holds a block.
class DescriptorBuffer : public std::streambuf {
 public:
  DescriptorBuffer(const fs::path& file, const ReadDescriptor& descriptor, std::size_t largest)
      : file_(file), descriptor_(descriptor), largest_(largest) {
    refuseMore(file_, descriptor_.size(), largest_);
  }

 protected:
  int_type underflow() override {
    const std::size_t count = descriptor_.read(block_.data(), block_.size());
    if (count == 0) return traits_type::eof();
    read_ += count;
    refuseMore(file_, read_, largest_);
    setg(block_.data(), block_.data(), block_.data() + count);
    return traits_type::to_int_type(block_.front());
  }

 private:
  const fs::path& file_;
  const ReadDescriptor& descriptor_;
  std::size_t largest_, read_ = 0;
  std::array<char, 1 << 16> block_;
};

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

bool isTemporaryFile(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with(kTemporaryBegin) && name.ends_with(kTemporaryEnd);
}

std::string readFile(const fs::path& file, std::size_t largest) {
  const ReadDescriptor descriptor(file);
  const std::size_t size = descriptor.size();
  refuseMore(file, size, largest);
  std::string content;
  content.reserve(size);  // growing would need it twice
  std::array<char, 1 << 16> block;
  while (const std::size_t count = descriptor.read(block.data(), block.size())) {
    refuseMore(file, content.size() + count, largest);
    content.append(block.data(), count);
  }
  return content;
}

Json readJson(const fs::path& file, const MostListed& most_listed) {
  constexpr int kDeepest = 64;                              // what writes or shows JSON calls itself once per level
  constexpr std::size_t kLargest = std::size_t{64} << 20U;  // values take up to sixteen times the room of their text
  std::string key;
  std::size_t most = kWholeList, listed = 0;
  bool in_list = false;  // of the object itself
  const auto wanted = [&](int depth, Json::parse_event_t event, const Json& parsed) {
    using Event = Json::parse_event_t;
    if (depth > kDeepest) {
      throw DataError(fmt::format("{}: found JSON nested more than {} deep, expected less", file.string(), kDeepest));
    }
    const bool begins = event == Event::value || event == Event::object_start || event == Event::array_start;
    if (depth == 1 && event == Event::key) key = parsed.get_ref<const std::string&>();
    if (depth == 1 && begins) {
      in_list = event == Event::array_start;
      listed = 0;
      if (most_listed && key == "format" && parsed.is_string())
        most = most_listed(parsed.get_ref<const std::string&>());
    }
    return depth != 2 || !begins || !in_list || ++listed <= most;
  };
  const ReadDescriptor descriptor(file);
  DescriptorBuffer buffer(file, descriptor, kLargest);
  std::istream stream(&buffer);
  Json json = Json::parse(stream, wanted, /*allow_exceptions=*/false);
  if (json.is_discarded()) throw DataError(fmt::format("{}: found no JSON, expected it", file.string()));
  return json;
}

Json readJson(const fs::path& file) { return readJson(file, {}); }

}  // namespace simgap
