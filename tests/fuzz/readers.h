/// \file
/// Every reader of untrusted bytes, by name: what the fuzzers call, what must pass over the corpora in every test run,
/// and what must survive a failing allocation.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace simgap::test {

struct Reader {
  std::string_view name;            ///< of its corpus, too: tests/fuzz/corpus/NAME
  void (*read)(std::string bytes);  ///< may throw simgap::Error and std::bad_alloc, nothing else
};

/// Tables, gzip and YAML of every kind.
std::span<const Reader> inputReaders();
/// The state of a calibration, its settings, and results as pages read them.
std::span<const Reader> resultReaders();

}  // namespace simgap::test
