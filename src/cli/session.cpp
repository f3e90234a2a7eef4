#include "simgap/cli/session.h"

#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <iostream>
#include <iterator>
#include <limits>
#include <mutex>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"
#include "simgap/report/html/result_page.h"

namespace simgap {
namespace {

/// Warnings on lines of their own, whatever progress the terminal shows.
class SentenceSink : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    printSentence({message.payload.data(), message.payload.size()});
  }
  void flush_() override {}
};

/// stderr for people, log.txt (none while `file` is empty) for later; stdout is for results only.
void openLog(const CommonOptions& options, const std::filesystem::path& file = {}) {
  auto terminal = std::make_shared<SentenceSink>();
  terminal->set_level(options.quiet     ? spdlog::level::warn
                      : options.verbose ? spdlog::level::debug
                                        : spdlog::level::info);
  std::vector<spdlog::sink_ptr> sinks{terminal};
  if (!file.empty()) {
    sinks.push_back(std::make_shared<spdlog::sinks::basic_file_sink_mt>(file.string(), false));
    sinks.back()->set_level(spdlog::level::debug);
  }
  auto logger = std::make_shared<spdlog::logger>("simgap", sinks.begin(), sinks.end());
  logger->set_level(spdlog::level::debug);
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(logger);
}

/// What is wrong with a seed; empty when nothing is. CLI11 wraps what is negative or too large.
std::string seedProblem(const std::string& text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc() && stop == end) return {};
  return fmt::format("found {}, expected an integer from 0 to {}", text, std::numeric_limits<std::uint64_t>::max());
}

/// Of a file, or of standard input for "-", which can be read once.
std::string contentOf(const std::filesystem::path& file) {
  if (file != "-") return readFile(file);
  std::string content{std::istreambuf_iterator<char>(std::cin), {}};
  if (content.empty()) throw ConfigError("-: found nothing on standard input, expected a file there");
  return content;
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

CLI::Validator finiteNumber() {
  const auto problem = [](std::string& text) {
    return parseNumber(text) ? std::string() : fmt::format("found {}, expected a finite number", text);
  };
  return CLI::Validator(problem, "FINITE");
}

CsvOptions TableOptions::csv() const {
  CsvOptions options;
  options.skip_bad_rows = skip_bad_rows;
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
  if (run_ && !ended_) abandon(interruptRequested() ? "interrupted" : "failed");
}

const Input& Session::read(const std::string& role, const std::filesystem::path& file) {
  Input input{role, file, contentOf(file), ""};
  input.sha256 = sha256(input.content);
  return inputs_.emplace_back(std::move(input));
}

const Input& Session::input(const std::string& role) const { return *std::ranges::find(inputs_, role, &Input::role); }

CsvTable Session::readTable(const std::string& role, const std::filesystem::path& file, const CsvOptions& options) {
  std::string content = contentOf(file);
  inputs_.push_back({role, file, "", sha256(content)});
  return CsvTable::parse(std::move(content), file.string(), options);
}

void Session::begin(std::uint64_t seed) {
  directory_ = RunDirectory::create(options_.output.empty() ? RunDirectory::defaultPath(command_) : options_.output,
                                    options_.force);
  record(seed, nullptr);
}

void Session::resume(const std::filesystem::path& directory, std::uint64_t seed) {
  directory_ = RunDirectory::open(directory);
  record(seed, Json::parse(readFile(directory_->file("run.json")), nullptr, /*allow_exceptions=*/false));
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

void Session::finish(const Json& result, const std::string& table, const std::string& status) {
  directory_->write("result.json", result);
  abandon(status);
  const std::filesystem::path report = writeReport(*directory_);
  activity_.reset();
  if (options_.json) {
    std::cout << toText(result) << std::flush;
  } else {
    std::cout << wrapped(table) << "report: " << report.string() << std::endl;
  }
}

void Session::print(const std::string& text) {
  activity_.reset();
  std::cout << wrapped(text) << std::flush;
}

void Session::abandon(const std::string& status) {
  run_->write(*directory_, status);
  ended_ = true;
}

}  // namespace simgap
