// A libFuzzer target: the reader that the environment names in SIMGAP_READER reads whatever the fuzzer makes up. An
// Error is an answer; any other exception, and whatever the sanitizers see, is a bug.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "fuzz/readers.h"
#include "simgap/core/error.h"

namespace {

const simgap::test::Reader& chosenReader() {
  const char* const name = std::getenv("SIMGAP_READER");
  const auto readers = SIMGAP_FUZZED_READERS();
  const auto found = std::ranges::find(readers, std::string_view(name ? name : ""), &simgap::test::Reader::name);
  if (found != readers.end()) return *found;
  std::fputs("SIMGAP_READER has to be one of", stderr);
  for (const auto& reader : readers) std::fprintf(stderr, " %s", std::string(reader.name).c_str());
  std::fputs("\n", stderr);
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const simgap::test::Reader& reader = chosenReader();
  try {
    reader.read(std::string(reinterpret_cast<const char*>(bytes), size));
  } catch (const simgap::Error&) {
  }
  return 0;
}
