/// \file
/// Pages from result directories. A page is a function of the files alone, so that it can be made again at any time.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "simgap/core/json_pieces.h"
#include "simgap/report/html/page.h"
#include "simgap/report/html/result_files.h"

namespace simgap {

/// What one command's results look like: one file in a folder `pages` of src/report, found by CMake.
struct ResultPage {
  const char* format;  ///< of result.json: "simgap/calibrate/1"
  Page (*make)(const ResultFiles& files);
  std::size_t most_listed = kWholeList;  ///< elements of a list of result.json that it looks at
};

namespace pages {
std::span<const ResultPage* const> all();
}
/// The page for a format; null where there is none of its own.
const ResultPage* findPage(std::string_view format);

/// The page of a result, with its provenance from run.json. A format without a page of its own is shown as tables.
/// \throws DataError: result.json or a table is not as the command wrote it.
Page makePage(const ResultFiles& files);

/// Writes report.html. \param run  the record of the run where run.json does not yet hold how it ended
/// \returns its path. \throws ConfigError, DataError: as ResultFiles and makePage.
std::filesystem::path writeReport(const RunDirectory& directory, const Json& run = nullptr);

}  // namespace simgap
