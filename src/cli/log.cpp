#include "log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>

#include "simgap/core/error.h"
#include "simgap/core/progress.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

/// Sentences for people on lines of their own, whatever progress the terminal shows and whatever names in files hold.
class TerminalSink : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    printSentence(printable({message.payload.data(), message.payload.size()}));
  }
  void flush_() override {}
};

/// Lines without control characters in a file.
class FileSink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  FileSink(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}
  ~FileSink() override { ::close(descriptor_); }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    const std::string text = printable({line.data(), line.size()}, /*keep_lines=*/true);
    std::string_view rest = text;
    while (!rest.empty() && !failed_) {
      const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) sayFailure(errno);
      if (written > 0) rest.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  void flush_() override {}

 private:
  void sayFailure(int error) {
    failed_ = true;
    printSentence(fmt::format("{}: cannot be written: {}", printable(name_), std::strerror(error)));
  }

  int descriptor_;
  std::string name_;
  bool failed_ = false;
};

int openFile(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor >= 0) return descriptor;
  const char* const why = errno == ELOOP ? "it is a link, expected a file" : std::strerror(errno);
  throw ConfigError(fmt::format("{}: cannot be written: {}", file.string(), why));
}

}  // namespace

void openLog(const CommonOptions& options, const std::filesystem::path& file) {
  auto terminal = std::make_shared<TerminalSink>();
  terminal->set_level(options.quiet     ? spdlog::level::warn
                      : options.verbose ? spdlog::level::debug
                                        : spdlog::level::info);
  std::vector<spdlog::sink_ptr> sinks{terminal};
  if (!file.empty()) {
    sinks.push_back(std::make_shared<FileSink>(openFile(file), file.string()));
    sinks.back()->set_level(spdlog::level::debug);
  }
  auto logger = std::make_shared<spdlog::logger>("simgap", sinks.begin(), sinks.end());
  logger->set_level(spdlog::level::debug);
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(logger);
}

}  // namespace simgap
