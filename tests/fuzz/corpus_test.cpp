// Every file of the corpora, among them whatever once crashed a reader: it is read, or refused with a sentence.
#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/readers.h"
#include "simgap/core/error.h"
#include "support/files.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;

class Corpus : public testing::TestWithParam<Reader> {};

TEST_P(Corpus, IsReadOrRefused) {
  const fs::path folder = sourceFile("tests/fuzz/corpus") / std::string(GetParam().name);
  std::size_t read = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path());
    const std::string bytes = readText(entry.path());
    try {
      GetParam().read(bytes);
      ++read;
    } catch (const Error& error) {
      EXPECT_STRNE(error.what(), "");
    }
  }
  EXPECT_GT(read, 0u) << "one seed at least is whole";
}

/// A seed cut at every length, and with every byte replaced by one that often matters.
TEST_P(Corpus, CutAndDamagedIsReadOrRefused) {
  const fs::path folder = sourceFile("tests/fuzz/corpus") / std::string(GetParam().name);
  const std::string seed = readText(folder / "seed");
  const auto survives = [](const std::string& bytes) {
    try {
      GetParam().read(bytes);
    } catch (const Error&) {
    }
  };
  const std::size_t stride = 1 + seed.size() / 300;
  for (std::size_t at = 0; at < seed.size(); at += stride) {
    survives(seed.substr(0, at));
    for (const char byte : {'\0', '"', '[', '-', '9', '\n', '\xff'}) {
      std::string damaged = seed;
      damaged[at] = byte;
      survives(damaged);
    }
  }
}

std::string nameOf(const testing::TestParamInfo<Reader>& info) { return std::string(info.param.name); }
INSTANTIATE_TEST_SUITE_P(Inputs, Corpus, testing::ValuesIn(inputReaders().begin(), inputReaders().end()), nameOf);
INSTANTIATE_TEST_SUITE_P(Results, Corpus, testing::ValuesIn(resultReaders().begin(), resultReaders().end()), nameOf);

}  // namespace
}  // namespace simgap::test
