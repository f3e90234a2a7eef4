#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/report/poses/exchange_report.h"

namespace simgap::commands::convert {
namespace {

struct Options {
  CommonOptions common;
  std::string from, to, muscles;
};

/// What is read may not be what is written, by whatever way it is named.
void refuseOwnSource(const Options& options, const std::filesystem::path& source) {
  std::error_code none;
  if (!std::filesystem::equivalent(source, options.to, none)) return;
  throw ConfigError(options.to + ": found the file that is read as the one to write, expected another");
}

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  Session session("convert", options.common, argv);
  refuseOwnSource(options, options.from);
  if (!options.muscles.empty()) refuseOwnSource(options, options.muscles);
  if (std::filesystem::exists(options.to) && !options.common.force) {
    throw ConfigError(options.to + ": exists; --force replaces it");
  }
  const RobotFile from{session.read("robot", options.from).content, options.from};
  RobotFile muscles;
  if (!options.muscles.empty()) muscles = {session.read("muscles", options.muscles).content, options.muscles};
  const FileReader read = [&](const std::filesystem::path& file) {
    refuseOwnSource(options, file);
    return session.read("included", file).content;
  };
  const RobotExchange exchange = exchangeRobot(from, muscles, options.to, read);
  if (!options.common.dry_run) writeFileAtomically(options.to, exchange.text);
  options.common.json ? session.printJson(toJson(exchange)) : session.print(terminalTable(exchange));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("FROM", options->from, "arm (YAML), MJCF, URDF or SDF")->required();
  app.add_option("TO", options->to, "the same robot as .yaml (arm), .xml (MJCF) or .urdf")->required();
  app.add_option("--muscles", options->muscles, "muscles and tendons of the arm (YAML), instead of those of FROM");
  app.add_flag("--dry-run", options->common.dry_run, "check everything, write nothing");
  app.add_flag("--json", options->common.json, "print the result as JSON");
  app.add_flag("--force", options->common.force, "replace an existing file");
  app.add_flag("-q,--quiet", options->common.quiet, "no progress");
  return [options, argv] { return run(*options, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"convert", "a robot from or into MuJoCo's MJCF or URDF, and what is lost on the way",
                    "  simgap convert data/arm/arm.yaml arm.xml --force", define};

}  // namespace simgap::commands::convert
