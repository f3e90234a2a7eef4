#include <fmt/format.h>

#include "report/actuators/dynamics_tables.h"
#include "report/actuators/fit_page.h"
#include "report/actuators/response_page.h"
#include "simgap/core/units.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::predict {
namespace {

Page robotPage(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{
      "simgap predict",
      fmt::format("The robot's efforts over {} rows, {} from the log (of the effort, over all joints).",
                  result.at("rows").get<long>(), numberText(numberOf(result.at("relative_error")) * 100.0, "{:.3g} %")),
      result.at("warnings").get<std::vector<std::string>>()};
  page.verdict = {PageVerdict::Level::kGood, "done", "Each joint's error stands below.", ""};
  page.add(robotPredictionJoints(result));
  addResponses(files.table("prediction.csv"), "_measured", "_predicted", page);
  return page;
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  if (result.at("model") == "robot") return robotPage(files);
  const UnitName target = splitUnit(result.at("predicts").get<std::string>());
  Page page{"simgap predict",
            fmt::format("The {} model predicts {} for {} rows", result.at("model").get<std::string>(), target.stem,
                        result.at("rows").get<long>()),
            {}};
  page.answer += result.at("rms_error").is_number()
                     ? fmt::format(", {:.4g} {} (RMS) from the log.", numberOf(result.at("rms_error")), target.unit)
                     : "; the log holds nothing to compare with.";
  page.verdict = {PageVerdict::Level::kGood, "done",
                  result.at("rms_error").is_number() ? "What is left may have a cause that can be named."
                                                     : "Nothing in the log says how right it is.",
                  fmt::format("simgap diagnose {} --log {}", files.input("model", "MODEL"), files.input("log", "LOG"))};
  if (result.at("model") == "gearbox") page.verdict->command.clear();
  if (const long left = result.at("left_out").get<long>(); left > 0) {
    page.notes.push_back(fmt::format("{} rows were left out, or lie outside the model's range.", left));
  }
  addResponses(files.table("prediction.csv"), "_measured", "_predicted", page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/predict/1", make};

}  // namespace simgap::pages::predict
