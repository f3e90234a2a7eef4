#include "simgap/cli/session.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <limits>
#include <mutex>

#include "log.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/ranks.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"
#include "simgap/report/html/result_page.h"

namespace simgap {
namespace {

/// What is wrong with a seed; empty when nothing is. CLI11 wraps what is negative or too large.
std::string seedProblem(const std::string& text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc() && stop == end) return {};
  return fmt::format("found {}, expected an integer from 0 to {}", text, std::numeric_limits<std::uint64_t>::max());
}

/// Results go out through one door that notices when nobody can take them. \throws ConfigError when stdout is full or
/// gone
void printResult(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) throw ConfigError(fmt::format("the standard output cannot be written: {}", std::strerror(errno)));
}

/// Of a file, or of standard input for "-", which can be read once; of the first rank.
std::string contentOf(const std::filesystem::path& file) {
  return shareFromFirstRank([&] {
    if (file != "-") return readFile(file);
    std::string content = readFile("/dev/stdin");
    if (content.empty()) throw ConfigError("-: found nothing on standard input, expected a file there");
    return content;
  });
}

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

}  // namespace

void CommonOptions::add(CLI::App& app) {
  app.add_option("--seed", seed, "seed of all random numbers")->check(&seedProblem, "UINT64");
  app.add_option("--threads", threads, "worker threads; 0 takes all (the result is the same)")
      ->check(CLI::Range(0, 4096));
  app.add_flag("--dry-run", dry_run, "check everything, say what would be done, write nothing");
  app.add_flag("--json", json, "print result.json instead of the table");
  app.add_option("-o,--output", output, "result directory (default: runs/<command>-<UTC time>)");
  app.add_flag("--force", force, "replace an existing result directory");
  app.add_flag("-q,--quiet", quiet, "no progress");
  app.add_flag("-v,--verbose", verbose, "say more");
}

void TableOptions::add(CLI::App& app) {
  app.add_option("--map", map,
                 "a column that has another name in the file; *-0.001 multiplies it, too; may be repeated")
      ->type_name("NAME=COLUMN[*FACTOR]")
      ->allow_extra_args(false);  // what follows is the next argument, not the next entry
  app.add_flag("--skip-bad-rows", skip_bad_rows,
               "drop and count rows that cannot be read, instead of refusing the file");
}

void LogFileOptions::add(CLI::App& app) {
  app.add_option("--topic", topics,
                 "of a recording (MCAP, rosbag2): a topic, or those of its numbers that FIELD names; may be repeated")
      ->type_name("NAME[:FIELD]")
      ->allow_extra_args(false);
  TableOptions::add(app);
}

CLI::Validator finiteNumber() {
  const auto problem = [](std::string& text) {
    return parseNumber(text) ? std::string() : fmt::format("found {}, expected a finite number", text);
  };
  return CLI::Validator(problem, "FINITE");
}

CLI::Validator positiveNumber() {
  const auto problem = [](std::string& text) {
    const std::optional<double> number = parseNumber(text);
    return number && *number > 0.0 ? std::string() : fmt::format("found {}, expected a number above 0", text);
  };
  return CLI::Validator(problem, "POSITIVE");
}

void refuseOptions(const CLI::App& app, std::initializer_list<const char*> options, const std::string& sentence) {
  for (const char* name : options) {
    const CLI::Option* option = app.get_option_no_throw(name);
    if (option != nullptr && option->count() > 0) throw ConfigError(fmt::format("found {} {}", name, sentence));
  }
}

CsvOptions TableOptions::csv() const {
  CsvOptions options;
  options.skip_bad_rows = skip_bad_rows;
  options.missing_advice = "; --map NAME=COLUMN says that COLUMN of the file is NAME";
  for (const std::string& entry : map) {
    const auto equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size()) {
      throw ConfigError(fmt::format("--map: found '{}', expected canonical=column or canonical=column*factor", entry));
    }
    const std::string name = entry.substr(0, equals);
    std::string column = entry.substr(equals + 1);
    const auto star = column.rfind('*');
    const auto factor = star == std::string::npos ? std::nullopt : parseNumber(column.substr(star + 1));
    if (factor == 0.0) throw ConfigError(fmt::format("--map: found the factor 0 in '{}', expected another", entry));
    if (factor && star > 0) {
      options.scale[name] = *factor;
      column.resize(star);
    }
    options.rename[name] = std::move(column);
  }
  return options;
}

Session::Session(std::string command, const CommonOptions& options, const std::vector<std::string>& argv)
    : command_(std::move(command)), options_(options), argv_(argv) {
  if (options_.threads > 0) {
    threads_.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options_.threads));
  }
  openLog(options_);  // the inputs are read before there is a log.txt
  activity_.emplace(command_, 0, options_.quiet);
}

Session::~Session() {
  if (!run_ || ended_) return;
  try {
    abandon(interruptRequested() ? "interrupted" : "failed");
  } catch (const std::exception& error) {  // the disk is full: what main says is why the run failed
    printSentence("simgap: the run stays recorded as unfinished: " + printable(error.what()));
  }
}

const Input& Session::read(const std::string& role, const std::filesystem::path& file) {
  Input input{role, file, contentOf(file), ""};
  input.sha256 = sha256(input.content);
  return inputs_.emplace_back(std::move(input));
}

const Input& Session::input(const std::string& role) const { return *std::ranges::find(inputs_, role, &Input::role); }

std::string Session::take(const std::string& role, const std::filesystem::path& file) {
  std::string content = contentOf(file);
  inputs_.push_back({role, file, "", sha256(content)});
  return content;
}

void Session::begin(std::uint64_t seed) {
  if (!isFirstRank()) return void(directory_ = RunDirectory::unwritten(options_.output));
  directory_ = RunDirectory::create(options_.output.empty() ? RunDirectory::defaultPath(command_) : options_.output,
                                    options_.force);
  record(seed, nullptr);
}

void Session::resume(const std::filesystem::path& directory, std::uint64_t seed) {
  if (!isFirstRank()) return void(directory_ = RunDirectory::unwritten(directory));
  directory_ = RunDirectory::open(directory);
  record(seed, readJson(directory_->file("run.json")));
}

void Session::record(std::uint64_t seed, const Json& earlier) {
  run_.emplace(argv_, seed, options_.threads);
  for (const Input& input : inputs_) run_->addHashedInput(input.role, input.file, input.sha256);
  if (earlier.is_object()) run_->addEarlier(earlier);
  run_->write(*directory_, "running");  // before all other files: it makes the directory ours to replace
  openLog(options_, directory_->file("log.txt"));
  spdlog::debug("{}", join(argv_));
  spdlog::debug("threads: {}", tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void Session::finish(const Json& result, const std::string& table, const std::string& status, const LongList& list) {
  if (!isFirstRank()) return;
  JsonPieces file(result, list);
  writeFileAtomically(directory_->file("result.json"), [&] { return file.next(); });
  run_->end(status);
  const std::filesystem::path report = writeReport(*directory_, run_->json());
  activity_.reset();
  if (options_.json) {
    JsonPieces text(result, list);
    for (std::string_view piece = text.next(); !piece.empty(); piece = text.next()) printResult(piece);
  } else {
    printResult(printable(fmt::format("{}report: {}\n", wrapped(table), report.string()), /*keep_lines=*/true));
  }
  run_->write(*directory_);  // last: a run is done when everything is there and somebody has been told
  ended_ = true;
}

void Session::print(const std::string& text) {
  activity_.reset();
  printResult(printable(wrapped(text), /*keep_lines=*/true));
}

void Session::printJson(const Json& result) {
  activity_.reset();
  printResult(toText(result));
}

void Session::abandon(const std::string& status) {
  if (!isFirstRank()) return;
  ended_ = true;  // also when it cannot be recorded: the destructor would fail once more
  run_->write(*directory_, status);
}

}  // namespace simgap
