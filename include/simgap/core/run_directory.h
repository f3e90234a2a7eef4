/// \file
/// Files that are there completely or not at all, and the directory every command leaves.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace simgap {

/// Ordered, so that files read in the order they were written.
using Json = nlohmann::ordered_json;

/// JSON has no NaN and no infinity: such a number is null.
inline Json numberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// Writes a file atomically: temporary file in the same folder, fsync, rename, fsync of the folder.
/// \throws ConfigError when the folder cannot be written.
void writeFileAtomically(const std::filesystem::path& file, std::string_view content);
/// The same in pieces, for what does not fit in memory; an empty piece is the end.
void writeFileAtomically(const std::filesystem::path& file, const std::function<std::string_view()>& next_piece);

/// A file that writeFileAtomically had not finished, by its name.
bool isTemporaryFile(const std::filesystem::path& file);

/// No file that is read, and nothing that is unpacked from one, may hold more bytes: an endless file ends here.
inline constexpr std::size_t kLargestFile = (std::size_t{1} << 32U) - 1;

/// The whole file, or what comes out of a pipe until its end. \throws ConfigError "FILE: cannot be read: why", or that
/// it has more than `largest` bytes; InterruptedError when the user no longer wants to wait for it
std::string readFile(const std::filesystem::path& file, std::size_t largest = kLargestFile);

/// A JSON file. \throws ConfigError as readFile; DataError: no JSON, or nested deeper than anything simgap writes.
Json readJson(const std::filesystem::path& file);

/// SHA-256 of a text, in hexadecimal.
std::string sha256(std::string_view content);

/// JSON as it stands in files: indented, with a final newline; bytes that are no UTF-8 become U+FFFD.
std::string toText(const Json& json);

/// UTC time: "2026-11-20T19:46:41Z"; with `compact` "20261120T194641Z" as it stands in directory names.
std::string utcTime(bool compact = false);

/// The result directory of a command. It is made only after all input was read, so that bad input leaves nothing. While
/// it lives no other process has it.
class RunDirectory {
 public:
  /// \throws ConfigError when the directory exists and `force` is not set, or when, with `force`, it is not empty and
  ///         holds no run.json (it is then not ours to replace), or when another process works there.
  static RunDirectory create(const std::filesystem::path& directory, bool force);
  /// An existing run, to go on with. \throws ConfigError when it holds no run.json, or another process works there.
  static RunDirectory open(const std::filesystem::path& directory);
  /// runs/<command>-<UTC time>; "-2", "-3" … is added when a run of the same second has taken the name.
  static std::filesystem::path defaultPath(std::string_view command);

  /// A directory of that name in which nothing is written: that of a rank that is not the first.
  static RunDirectory unwritten(const std::filesystem::path& directory);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path file(std::string_view name) const { return path_ / name; }
  /// \param name  also of a folder in it, "candidates/given.yaml", which is made
  void write(std::string_view name, std::string_view content) const;
  /// Indented, with a final newline. A template, because every text would convert to Json and the call be ambiguous.
  template <std::same_as<Json> T>
  void write(std::string_view name, const T& json) const {
    write(name, std::string_view(toText(json)));
  }

 private:
  RunDirectory(std::filesystem::path path, std::shared_ptr<const int> lock)
      : path_(std::move(path)), lock_(std::move(lock)) {}
  std::filesystem::path path_;
  std::shared_ptr<const int> lock_;
  bool written_ = true;
};

/// run.json (`simgap/run/1`): what ran, with what, on what, and how it ended.
class RunRecord {
 public:
  /// Records version, git hash, argv, seed, threads, machine and start; status "running".
  RunRecord(const std::vector<std::string>& argv, std::uint64_t seed, int threads);
  /// Adds an input's path and SHA-256.
  void addInput(std::string_view role, const std::filesystem::path& file, std::string_view content) {
    addHashedInput(role, file, sha256(content));
  }
  /// The same for a file whose SHA-256 is known already.
  void addHashedInput(std::string_view role, const std::filesystem::path& file, std::string_view hash);
  /// Keeps the record of an earlier session of the same run, whose inputs and command line would be lost otherwise.
  void addEarlier(const Json& record);
  /// Status "running", "done", "failed: <sentence>" or "interrupted", with the duration so far.
  void end(std::string_view status);
  const Json& json() const { return json_; }
  /// Writes run.json.
  void write(const RunDirectory& directory) const;
  void write(const RunDirectory& directory, std::string_view status) {
    end(status);
    write(directory);
  }

 private:
  Json json_;
  double start_s_;
};

}  // namespace simgap
