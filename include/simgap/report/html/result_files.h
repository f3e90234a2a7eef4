/// \file
/// The files that a command has left in its result directory, read back.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"
#include "simgap/report/table.h"

namespace simgap {

class ResultFiles {
 public:
  /// Reads result.json and, without a `run` that is given, run.json.
  /// \throws ConfigError: a directory without them; DataError: one of them is no JSON object.
  explicit ResultFiles(std::filesystem::path directory, const Json& run = nullptr);

  const std::filesystem::path& directory() const { return directory_; }
  const Json& result() const { return result_; }
  const Json& run() const { return run_; }
  bool has(std::string_view name) const;
  /// The file that the run read in that role, as a word for a shell; `otherwise` when there was none.
  std::string input(std::string_view role, std::string_view otherwise) const;
  /// A file of the directory that the run wrote into, as a word for a shell.
  std::string path(std::string_view name) const;
  /// \throws ConfigError, DataError: as CsvTable::load
  CsvTable table(std::string_view name) const;

 private:
  std::filesystem::path directory_;
  Json result_, run_;
};

/// A column of numbers, shape (rows); NaN for a cell that is empty or not finite. \throws DataError: no such column, a
/// cell that is no number.
std::vector<double> numbersOf(const CsvTable& table, const std::string& column);
/// The same for the rows whose text in `key` is `value`.
std::vector<double> numbersWhere(const CsvTable& table, const std::string& column, const std::string& key,
                                 const std::string& value);
/// Texts of a column, each once, in the order of the file.
std::vector<std::string> distinctOf(const CsvTable& table, const std::string& column);

}  // namespace simgap
