#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "report/actuators/dynamics_tables.h"
#include "report/actuators/fit_page.h"
#include "report/actuators/response_page.h"
#include "simgap/core/json_numbers.h"
#include "simgap/core/units.h"
#include "simgap/report/actuators/stretch_report.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::predict {
namespace {

Page robotMotionPage(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap predict", robotMotionAnswer(result), result.at("warnings").get<std::vector<std::string>>()};
  page.verdict = {PageVerdict::Level::kGood, "done", "Each joint's motion stands below.", ""};
  page.add(robotMotionJoints(result));
  addResponses(files.table("prediction.csv"), "_measured", "_predicted", page);
  return page;
}

Page robotPage(const ResultFiles& files) {
  const Json& result = files.result();
  if (result.at("predicts") == "position") return robotMotionPage(files);
  Page page{"simgap predict",
            fmt::format("The robot's efforts over {} rows, {} from the log (of the effort, over all joints).",
                        wholeNumber(result.at("rows")),
                        numberText(numberOf(result.at("relative_error")) * 100.0, "{:.3g} %")),
            result.at("warnings").get<std::vector<std::string>>()};
  page.verdict = {PageVerdict::Level::kGood, "done", "Each joint's error stands below.", ""};
  page.add(robotPredictionJoints(result));
  addResponses(files.table("prediction.csv"), "_measured", "_predicted", page);
  return page;
}

/// Stretch over load at three angles, and over both (003 fig. 15a).
void addStretch(const ResultFiles& files, Page& page) {
  if (!files.has("stretch.csv")) return;
  const CsvTable table = files.table("stretch.csv");
  const std::vector<double> load = table.quantity("load", "Nm"), angle = table.quantity("joint_position", "rad"),
                            stretch = table.quantity("stretch", "rad"), model = table.quantity("model", "rad");
  std::vector<Series> lines;
  std::vector<double> angles = angle;
  std::ranges::sort(angles);
  angles.erase(std::unique(angles.begin(), angles.end()), angles.end());
  for (const std::size_t part : {1, 2, 3}) {
    const double at = angles[angles.size() * part / 4];
    Series line{fmt::format("measured at {:.2f} rad", at), {}, {}, Series::Style::kPoints};
    for (std::size_t i = 0; i < load.size(); ++i) {
      if (angle[i] != at) continue;
      line.x.push_back(load[i]);
      line.y.push_back(stretch[i]);
    }
    lines.push_back(std::move(line));
  }
  std::vector<std::size_t> order(load.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return load[i]; });
  Series law{"model", {}, {}};
  for (const std::size_t i : order) {
    law.x.push_back(load[i]);
    law.y.push_back(model[i]);
  }
  lines.push_back(std::move(law));
  page.addSection("Stretch between motor and joint");
  page.add(stretchTable(files.result()));
  page.add(lineChart("Stretch over load", {"load [N m]"}, {"stretch of the joint [rad]"}, lines));
  Map map = gridOf(table, "load_Nm", "joint_position_rad", stretch);
  map.unit = "rad";
  map.diverging = true;
  page.add(mapChart("Stretch over load and angle", {"load [N m]"}, {"joint [rad]"}, map));
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  if (result.at("model") == "robot") return robotPage(files);
  const UnitName target = splitUnit(result.at("predicts").get<std::string>());
  Page page{"simgap predict",
            fmt::format("The {} model predicts {} for {} rows", result.at("model").get<std::string>(), target.stem,
                        wholeNumber(result.at("rows"))),
            {}};
  page.answer += result.at("rms_error").is_number()
                     ? fmt::format(", {:.4g} {} (RMS) from the log.", numberOf(result.at("rms_error")), target.unit)
                     : "; the log holds nothing to compare with.";
  page.verdict = {PageVerdict::Level::kGood, "done",
                  result.at("rms_error").is_number() ? "What is left may have a cause that can be named."
                                                     : "Nothing in the log says how right it is.",
                  fmt::format("simgap diagnose {} --log {}", files.input("model", "MODEL"), files.input("log", "LOG"))};
  if (result.at("model") == "gearbox") page.verdict->command.clear();
  if (const long left = wholeNumber(result.at("left_out")); left > 0) {
    page.notes.push_back(fmt::format("{} rows were left out, or lie outside the model's range.", left));
  }
  if (result.contains("joint_angle")) page.answer = stretchAnswer(result);
  addResponses(files.table("prediction.csv"), "_measured", "_predicted", page);
  addStretch(files, page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/predict/1", make};

}  // namespace simgap::pages::predict
