#include <fmt/format.h>

#include "simgap/cli/command.h"
#include "simgap/core/text.h"
#include "simgap/report/html/result_page.h"

namespace simgap::commands::report {
namespace {

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>&) {
  auto directories = std::make_shared<std::vector<std::filesystem::path>>();
  app.add_option("DIR", *directories, "result directories of earlier runs")->required();
  return [directories] {
    for (const std::filesystem::path& directory : *directories) {
      fmt::print("report: {}\n", printable(writeReport(RunDirectory::open(directory)).string()));
    }
    return ExitCode::kDone;
  };
}

}  // namespace

extern const Command entry;
const Command entry{"report", "make report.html again from the files of a run, without running anything",
                    "  simgap fit-spring data/logs/shock-cord.csv.gz -o runs/spring\n"
                    "  simgap report runs/spring",
                    define};

}  // namespace simgap::commands::report
