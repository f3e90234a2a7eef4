#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "fuzz/readers.h"
#include "simgap/core/error.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/report/html/result_page.h"

namespace simgap::test {
namespace {

/// JSON as a file that stands in memory.
Json jsonOf(const std::string& bytes) {
  const int descriptor = ::memfd_create("input.json", MFD_CLOEXEC);
  const bool written = ::write(descriptor, bytes.data(), bytes.size()) == std::ssize(bytes);
  const auto file = std::filesystem::path("/proc/self/fd") / std::to_string(descriptor);
  struct Closer {
    int descriptor;
    ~Closer() { ::close(descriptor); }
  } const closer{descriptor};
  if (!written) throw std::bad_alloc();
  return readJson(file);
}

void readState(std::string bytes) { calibrationStateFromJson(jsonOf(bytes)); }

void readCalibration(std::string bytes) { CalibrationConfig::read(YamlNode::parse(bytes, "input.yaml")); }

/// The page of a result whose tables are not there: what stands in result.json alone.
void readResult(std::string bytes) {
  const Json result = jsonOf(bytes);
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("simgap-fuzz-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "run.json") << "{}";
  std::ofstream(folder / "result.json") << toText(result);
  const Json run = {{"argv", Json::array()}, {"version", ""},     {"git_hash", ""},   {"seed", 0},
                    {"start", ""},           {"duration_s", 0.0}, {"status", "done"}, {"inputs", Json::array()}};
  makePage(ResultFiles(folder, run));
}

constexpr std::array kReaders = {
    Reader{"state", readState},
    Reader{"calibration", readCalibration},
    Reader{"result", readResult},
};

}  // namespace

std::span<const Reader> resultReaders() { return kReaders; }

}  // namespace simgap::test
