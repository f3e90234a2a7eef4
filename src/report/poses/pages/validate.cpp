#include <fmt/format.h>

#include "report/poses/pose_page.h"
#include "report/poses/pose_tables.h"
#include "simgap/core/json_numbers.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::validate {
namespace {

std::string answer(const Json& result) {
  std::string text = fmt::format("On {} of {} poses the simulation misses the robot by",
                                 wholeNumber(result.at("valid_poses")), result.at("poses").size());
  const char* separator = "";
  const Json mje = ofAllJoints(result, "mje");
  for (const auto& [joint, error] : mje.items()) {
    text += fmt::format("{} {}", separator, errorText(error, joint));
    separator = ",";
  }
  return text + " on average.";
}

std::vector<std::string> notes(const Json& result) {
  std::vector<std::string> notes;
  for (const Json& criterion : result.at("criteria")) {
    if (criterion.at("pass").get<bool>()) continue;
    notes.push_back(fmt::format("{} is {}, which fails the limit of {:g}.", criterion.at("name").get<std::string>(),
                                degreesCell(criterion.at("value")), criterion.at("limit").get<double>()));
  }
  return notes;
}

PageVerdict verdictOf(const ResultFiles& files, const std::vector<std::string>& failed) {
  using enum PageVerdict::Level;
  const Json& result = files.result();
  const std::string model = files.input("model", "MODEL.yaml"), poses = files.input("poses", "POSES.csv");
  const std::size_t of = result.at("poses").size();
  const auto valid = static_cast<std::size_t>(wholeNumber(result.at("valid_poses")));
  const std::string next = fmt::format("simgap diagnose {} --poses {}", model, poses);
  if (valid < of)
    return {kBad, fmt::format("{} of {} poses valid", valid, of), "In the others the arm does not come to rest.", next};
  if (!failed.empty()) return {kBad, "fails the limit", "", next};
  return {kGood, fmt::format("{} of {} poses valid", valid, of), "What is left may have a cause that can be named.",
          next};
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  const PoseErrorTables errors(files.table("errors.csv"), {""}, "replayed");
  Page page{"simgap validate", answer(result), notes(result)};
  page.verdict = verdictOf(files, page.notes);
  if (auto scene = armScene(files, errors.scenePoses())) page.add(std::move(*scene));
  Chart chart = errors.chart("replayed");
  chart.wide = true;
  page.add(std::move(chart));
  page.addSection("Numbers");
  page.add(validationErrors(result));
  if (!result.at("criteria").empty()) page.add(criteriaTable(result));
  page.add(errors.table(/*folded=*/false));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/validate/1", make};

}  // namespace simgap::pages::validate
