// Readers without memory: every allocation fails once in turn. What is thrown is std::bad_alloc or an Error, and
// nothing is left behind (the sanitizers see leaks).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <vector>

#include "fuzz/readers.h"
#include "simgap/core/error.h"
#include "support/files.h"

namespace {

thread_local long allocations_left = -1;  ///< until the one that fails; below 0 none does

void* allocate(std::size_t size) {
  if (allocations_left >= 0 && allocations_left-- == 0) throw std::bad_alloc();
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

class Allocation : public testing::TestWithParam<Reader> {};

TEST_P(Allocation, FailsOnceInTurn) {
  const auto folder = sourceFile("tests/fuzz/corpus") / std::string(GetParam().name);
  const std::string seed = readText(folder / "seed");
  GetParam().read(seed);  // what is made once for the whole program is there now
  constexpr long kMost = 2'000'000;
  long refused = 0;
  for (long at = 0; at < kMost; at += 1 + at / 100) {  // all of the first hundred, then one in a hundred
    std::string bytes = seed;
    bool failed = false;
    allocations_left = at;
    try {
      GetParam().read(std::move(bytes));
    } catch (const std::bad_alloc&) {
      failed = true;
    } catch (const Error&) {
      failed = true;
    }
    const bool reached = allocations_left < 0;
    allocations_left = -1;
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
/// Those of YAML and tables. nlohmann::json takes memory where a value is destroyed, to be done with nested ones
/// without recursion: where there is none, the program ends (docs/reliability.md).
std::vector<Reader> withoutJson() {
  std::vector<Reader> readers(resultReaders().begin(), resultReaders().end());
  std::erase_if(readers, [](const Reader& reader) {
    constexpr std::array kJson = {"state", "motion_state", "result", "compared", "budget", "serve"};
    return std::ranges::find(kJson, reader.name) != kJson.end();
  });
  return readers;
}
INSTANTIATE_TEST_SUITE_P(Results, Allocation, testing::ValuesIn(withoutJson()), nameOf);

}  // namespace
}  // namespace simgap::test
