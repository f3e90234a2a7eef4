// Readers without memory: every allocation fails once in turn. What is thrown is std::bad_alloc or an Error, and
// nothing is left behind (the sanitizers see leaks).
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <vector>

#include "fuzz/readers.h"
#include "simgap/core/error.h"
#include "simgap/core/memory.h"
#include "support/files.h"

/// OpenCV's own, where the second of the allocations of a matrix fails.
extern "C" const char* __lsan_default_suppressions() { return "leak:libopencv_core\n"; }

namespace {

thread_local long allocations_left = -1;  ///< until the one that fails; below 0 none does

void* allocate(std::size_t size) {
  if (allocations_left >= 0 && allocations_left-- == 0) {
    if (const std::new_handler handler = std::get_new_handler()) handler();
    throw std::bad_alloc();
  }
  void* const memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
// Who asks so does without: nobody has to notice.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return std::malloc(size == 0 ? 1 : size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return std::malloc(size == 0 ? 1 : size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace simgap::test {
namespace {

struct Attempt {
  bool reached;  ///< the reader came to that allocation
  bool failed;   ///< and said so
};
/// Reads while that allocation fails.
Attempt readWithout(const Reader& reader, std::string bytes, long at) {
  bool failed = false;
  allocations_left = at;
  try {
    reader.read(std::move(bytes));
  } catch (const std::bad_alloc&) {
    failed = true;
  } catch (const Error&) {
    failed = true;
  }
  const bool reached = allocations_left < 0;
  allocations_left = -1;
  return {reached, failed};
}

class Allocation : public testing::TestWithParam<Reader> {};

TEST_P(Allocation, FailsOnceInTurn) {
  const auto folder = sourceFile("tests/fuzz/corpus") / std::string(GetParam().name);
  const std::string seed = readText(folder / "seed");
  GetParam().read(seed);  // what is made once for the whole program is there now
  constexpr long kMost = 2'000'000;
  long refused = 0;
  for (long at = 0; at < kMost; at += 1 + at / 100) {  // all of the first hundred, then one in a hundred
    const auto [reached, failed] = readWithout(GetParam(), seed, at);
    if (!reached) {
      EXPECT_FALSE(failed);
      EXPECT_GT(refused, 0);
      return;
    }
    refused += failed ? 1 : 0;
    EXPECT_TRUE(failed) << "allocation " << at << " failed and nobody noticed";
  }
  FAIL() << "more allocations than expected";
}

std::string nameOf(const testing::TestParamInfo<Reader>& info) { return std::string(info.param.name); }
INSTANTIATE_TEST_SUITE_P(Inputs, Allocation, testing::ValuesIn(inputReaders().begin(), inputReaders().end()), nameOf);
bool readsJson(const Reader& reader) {
  constexpr std::array kJson = {"state", "motion_state", "result", "compared", "budget", "serve"};
  return std::ranges::find(kJson, reader.name) != kJson.end();
}
std::vector<Reader> resultReadersThat(bool read_json) {
  std::vector<Reader> readers(resultReaders().begin(), resultReaders().end());
  std::erase_if(readers, [&](const Reader& reader) { return readsJson(reader) != read_json; });
  return readers;
}
INSTANTIATE_TEST_SUITE_P(Results, Allocation, testing::ValuesIn(resultReadersThat(false)), nameOf);

/// nlohmann::json takes memory where a value is destroyed, to be done with nested ones without recursion, and nothing
/// can be thrown there: what main installs ends the program with a sentence. So the reader runs in a process of its
/// own, which goes on behind the allocation that ended the one before.
class JsonAllocation : public testing::TestWithParam<Reader> {};

constexpr int kUnnoticed = 40, kOtherException = 41;  // exit codes of the child

/// Shared by the processes.
struct Tally {
  std::atomic<long> at{0};       ///< the allocation that fails
  std::atomic<long> refused{0};  ///< reads that an exception ended
};

void readWithFailures(const Reader& reader, const std::string& seed, Tally& tally) try {
  installNoMemoryHandler();
  reader.read(seed);
  for (;; tally.at = tally.at + 1 + tally.at / 100) {
    const auto [reached, failed] = readWithout(reader, seed, tally.at);
    if (!reached) ::_exit(failed ? kOtherException : 0);
    if (!failed) ::_exit(kUnnoticed);
    ++tally.refused;
  }
} catch (...) {
  ::_exit(kOtherException);
}

TEST_P(JsonAllocation, FailsOnceInTurnOrEndsTheProgramWithASentence) {
  const std::string seed = readText(sourceFile("tests/fuzz/corpus") / std::string(GetParam().name) / "seed");
  const TemporaryFolder left_behind;  // by processes that end without a word
  void* const page =
      ::mmap(nullptr, sizeof(Tally), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, /*fd=*/-1, /*offset=*/0);
  ASSERT_NE(page, MAP_FAILED);
  Tally& tally = *new (page) Tally;
  for (;; ++tally.at) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      std::freopen("/dev/null", "w", stderr);
      ::setenv("TMPDIR", left_behind.path().c_str(), /*overwrite=*/1);
      readWithFailures(GetParam(), seed, tally);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status)) << "allocation " << tally.at << ": signal " << WTERMSIG(status);
    if (WEXITSTATUS(status) == 0) break;
    ASSERT_EQ(WEXITSTATUS(status), static_cast<int>(ExitCode::kUsage)) << "allocation " << tally.at;
  }
  EXPECT_GT(tally.refused, 0);
}

INSTANTIATE_TEST_SUITE_P(Results, JsonAllocation, testing::ValuesIn(resultReadersThat(true)), nameOf);

}  // namespace
}  // namespace simgap::test
