#include "simgap/report/html/result_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/error.h"

namespace simgap {
namespace {

/// "simgap/calibrate/1" -> "calibrate"
std::string commandOf(const std::string& format) {
  const std::size_t begin = format.find('/'), end = format.rfind('/');
  return begin < end ? format.substr(begin + 1, end - begin - 1) : format;
}

std::string formatOf(const ResultFiles& files) {
  const auto format = files.result().find("format");
  return format == files.result().end() || !format->is_string() ? "" : format->get<std::string>();
}

/// What a command without a page of its own has found: numbers and words in one table, lists of objects in their own.
Page plainPage(const ResultFiles& files) {
  const std::string command = commandOf(formatOf(files));
  Page page{"simgap " + command, "The figures of this run.", {}};
  Table figures{"Figures", {"name", "value"}, {}};
  std::vector<Table> tables;
  for (const auto& [key, value] : files.result().items()) {
    if (key == "format") continue;
    const bool objects = value.is_array() && !value.empty() && value.front().is_object();
    if (!objects) {
      figures.rows.push_back({key, cellText(value)});
      continue;
    }
    std::vector<std::string> names;
    for (const auto& [name, cell] : value.front().items()) names.push_back(name);
    tables.push_back(recordTable(key, value, names));
  }
  page.add(std::move(figures));
  for (Table& table : tables) page.add(std::move(table));
  return page;
}

void addProvenance(const Json& run, Page& page) {
  const auto words = [](const Json& argv) {
    std::string text;
    for (const Json& word : argv) text += (text.empty() ? "" : " ") + cellText(word);
    return text;
  };
  page.provenance.emplace_back("command", words(run.at("argv")));
  page.provenance.emplace_back(
      "version", fmt::format("simgap {} ({})", cellText(run.at("version")), cellText(run.at("git_hash"))));
  page.provenance.emplace_back("seed", cellText(run.at("seed")));
  page.provenance.emplace_back("began", cellText(run.at("start")));
  page.provenance.emplace_back("took", fmt::format("{:.3g} s", run.at("duration_s").get<double>()));
  page.provenance.emplace_back("ended", cellText(run.at("status")));
  for (const Json& input : run.at("inputs")) {
    page.provenance.emplace_back(cellText(input.at("role")) + " (SHA-256)",
                                 cellText(input.at("file")) + ": " + cellText(input.at("sha256")));
  }
  for (const Json& earlier : run.value("earlier", Json::array())) {
    page.provenance.emplace_back("begun by", words(earlier.at("argv")));
  }
  const std::string status = cellText(run.at("status"));
  if (status != "done") page.verdict = {PageVerdict::Level::kBad, "not done", "The run ended as: " + status + ".", ""};
}

}  // namespace

const ResultPage* findPage(std::string_view format) {
  const auto known = std::ranges::find(pages::all(), format, [](const ResultPage* page) { return page->format; });
  return known == pages::all().end() ? nullptr : *known;
}

Page makePage(const ResultFiles& files) {
  const std::string format = formatOf(files);
  const ResultPage* const known = findPage(format);
  const auto file = [&](const char* name) { return (files.directory() / name).string(); };
  Page page;
  try {
    page = known == nullptr ? plainPage(files) : known->make(files);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {  // of JSON, or of a place that is not there
    throw DataError(fmt::format("{}: is no complete result ({}): {}", file("result.json"), format, error.what()));
  }
  try {
    addProvenance(files.run(), page);
  } catch (const Json::exception& error) {
    throw DataError(fmt::format("{}: is no complete record of a run: {}", file("run.json"), error.what()));
  }
  return page;
}

std::filesystem::path writeReport(const RunDirectory& directory, const Json& run) {
  directory.write("report.html", renderPage(makePage(ResultFiles(directory.path(), run))));
  return directory.file("report.html");
}

}  // namespace simgap
