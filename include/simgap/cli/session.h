/// \file
/// What every command does around its own work: common options, inputs, log, result directory, output.
#pragma once

#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/core/json_pieces.h"
#include "simgap/core/progress.h"
#include "simgap/core/run_directory.h"

namespace simgap {

struct CommonOptions {
  std::optional<std::uint64_t> seed;
  int threads = 0;  ///< 0: all
  bool dry_run = false;
  bool json = false;
  std::filesystem::path output;
  bool force = false;
  bool quiet = false;
  bool verbose = false;
  void add(CLI::App& app);
};

/// Options of commands that read measured tables.
struct TableOptions {
  std::vector<std::string> map;  ///< "canonical=column" or "canonical=column*factor"
  bool skip_bad_rows = false;
  void add(CLI::App& app);
  CsvOptions csv() const;  ///< \throws ConfigError for a `map` without '='
};

/// Options of commands that read logs.
struct LogFileOptions : TableOptions {
  std::vector<std::string> topics;  ///< as readBag
  void add(CLI::App& app);
};

/// Refuses NaN and infinity, which CLI11 takes.
CLI::Validator finiteNumber();
/// The same above 0; CLI::PositiveNumber says what it expects with 309 digits.
CLI::Validator positiveNumber();

/// \throws ConfigError "found OPTION SENTENCE" for the first of `options` that was given. \param sentence  with what it
/// would be ignored, and what was expected
void refuseOptions(const CLI::App& app, std::initializer_list<const char*> options, const std::string& sentence);

/// An input file as it was read.
struct Input {
  std::string role;  ///< "model", "poses", …
  std::filesystem::path file;
  std::string content;  ///< empty for a log, which can be large
  std::string sha256 = {};
};

/// One run of a command, from its inputs to its result directory. While it lives, the process works on no more threads
/// than the user allows.
class Session {
 public:
  /// \param command  its name.
  Session(std::string command, const CommonOptions& options, const std::vector<std::string>& argv);
  ~Session();  ///< a run that did not end is recorded as failed, or as interrupted, where that can be written

  /// Reads a file that the user named. \throws ConfigError when it cannot be read.
  const Input& read(const std::string& role, const std::filesystem::path& file);
  /// The content of a file that the user named, which is not kept. \throws ConfigError when it cannot be read.
  std::string take(const std::string& role, const std::filesystem::path& file);
  const std::vector<Input>& inputs() const { return inputs_; }
  const Input& input(const std::string& role) const;  ///< the first of that role; it must have been read

  /// Makes the result directory, once all input has been read and checked, and begins run.json and log.txt.
  void begin(std::uint64_t seed);
  /// The same in the directory of an earlier run.
  void resume(const std::filesystem::path& directory, std::uint64_t seed);

  const RunDirectory& directory() const { return *directory_; }
  const CommonOptions& options() const { return options_; }

  /// Writes result.json, makes report.html of what is in the directory, prints the result and ends run.json, in this
  /// order: only what is complete is recorded as done. \throws ConfigError, DataError: one of them fails.
  /// \param list  of the result, where it does not fit in memory
  void finish(const Json& result, const std::string& table, const std::string& status = "done",
              const LongList& list = {});
  /// A text on stdout instead of a result: what a dry run would do.
  void print(const std::string& text);
  /// A result that stands in no directory.
  void printJson(const Json& result);
  /// Records how a run ended that has no result.
  void abandon(const std::string& status);

 private:
  void record(std::uint64_t seed, const Json& earlier);

  std::string command_;
  CommonOptions options_;
  std::optional<tbb::global_control> threads_;  ///< empty: all the machine has
  std::optional<Progress> activity_;            ///< shown while nothing else is, until there is a result
  std::vector<std::string> argv_;
  std::vector<Input> inputs_;
  std::optional<RunDirectory> directory_;
  std::optional<RunRecord> run_;
  bool ended_ = false;
};

}  // namespace simgap
