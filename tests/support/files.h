/// \file
/// Files of tests: a folder that vanishes, texts in and out, small changes of texts.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace simgap::test {

/// A folder of its own, removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Writes a file and returns its path.
  std::filesystem::path put(const std::filesystem::path& name, std::string_view text) const;

 private:
  std::filesystem::path path_;
};

std::string readText(const std::filesystem::path& file);
void writeText(const std::filesystem::path& file, std::string_view text);
/// A file of the source tree.
std::filesystem::path sourceFile(const std::string& name);

/// Names of the files and folders in a folder, sorted; empty when there is no such folder.
std::vector<std::string> entries(const std::filesystem::path& folder);

/// The text with the first `from` replaced; asserts that there is one.
std::string replaced(std::string text, std::string_view from, std::string_view to);
/// The first `count` lines.
std::string firstLines(std::string_view text, std::size_t count);
std::size_t countOf(std::string_view text, std::string_view what);

/// The bytes as gzip packs them.
std::string gzipped(std::string_view text);

/// The sentence of the simgap::Error that `action` throws, and its exit code: "3: FILE:2: ..."; "no error" without one.
std::string errorOf(const std::function<void()>& action);

}  // namespace simgap::test
