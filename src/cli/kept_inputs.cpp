#include "kept_inputs.h"

#include <fmt/format.h>

#include "simgap/core/ranks.h"
#include "simgap/core/run_directory.h"

namespace simgap {
namespace {

constexpr const char* kInputsFile = "inputs/inputs.json";

/// A copy that keepInputs made. A directory may come from somebody else: it must not name, or link to, other files.
std::string keptInput(const RunDirectory& directory, const std::string& name) {
  const std::filesystem::path file = directory.file(name), inputs = directory.file("inputs");
  const bool beside = std::filesystem::path(name).lexically_normal() == name && file.parent_path() == inputs;
  std::error_code none;
  const bool plain = std::filesystem::is_directory(std::filesystem::symlink_status(inputs, none)) &&
                     std::filesystem::is_regular_file(std::filesystem::symlink_status(file, none));
  if (beside && plain) return file.string();
  throw ConfigError(fmt::format("{}: found '{}', expected a file in {}", directory.file(kInputsFile).string(), name,
                                inputs.string()));
}

/// What keepInputs wrote, with the files' names looked at.
Json keptInputs(const std::filesystem::path& resumed) {
  const RunDirectory directory = RunDirectory::open(resumed);
  Json kept = readJson(directory.file(kInputsFile));
  for (const char* role : {"model", "poses", "validation"}) {
    if (kept.contains(role)) kept[role] = keptInput(directory, kept.at(role).get<std::string>());
  }
  return kept;
}

}  // namespace

void keepInputs(const Session& session, const TableOptions& table, const CalibrationConfig& config) {
  if (!isFirstRank()) return;
  const RunDirectory& directory = session.directory();
  std::filesystem::create_directories(directory.file("inputs"));
  Json kept = {{"map", table.map}, {"skip_bad_rows", table.skip_bad_rows}};
  for (const Input& input : session.inputs()) {
    const std::string extension = input.file.extension() == ".gz" ? ".csv.gz" : input.file.extension().string();
    const std::string name = "inputs/" + input.role + extension;
    directory.write(name, input.content);
    kept[input.role] = name;
  }
  directory.write(kKeptConfig, config.toYaml());
  directory.write(kInputsFile, kept);  // last: with it a run can be resumed
}

void takeKept(const std::filesystem::path& file, const std::function<Json()>& read,
              const std::function<void(const Json& kept)>& take) {
  try {
    take(Json::parse(shareFromFirstRank([&] { return toText(read()); })));
  } catch (const DataError& error) {
    throw ConfigError(error.what());
  } catch (const Json::exception& error) {
    throw ConfigError(fmt::format("{}: is no calibration that can be resumed: {}", file.string(), error.what()));
  }
}

KeptInputs readKeptInputs(const std::filesystem::path& resumed) {
  KeptInputs inputs;
  takeKept(
      resumed / kInputsFile, [&] { return keptInputs(resumed); },
      [&](const Json& kept) {
        kept.at("map").get_to(inputs.map);
        kept.at("skip_bad_rows").get_to(inputs.skip_bad_rows);
        kept.at("model").get_to(inputs.model);
        kept.at("poses").get_to(inputs.poses);
        if (kept.contains("validation")) kept.at("validation").get_to(inputs.validation);
      });
  return inputs;
}

}  // namespace simgap
