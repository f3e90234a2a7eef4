#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/poses/pose_page.h"
#include "report/poses/pose_tables.h"
#include "simgap/core/json_numbers.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::calibrate {
namespace {

std::string answer(const Json& result) {
  const Json failure = result.value("failure", Json(nullptr));
  if (failure.is_string()) return "Failed: " + failure.get<std::string>() + ".";
  const Json mje = ofAllJoints(result, "mje");
  const bool held_out = mje.contains("validation");
  const Json& judge = mje.at(held_out ? "validation" : "calibration");
  std::string text =
      held_out ? "On poses the search never saw the gap went" : "On the poses it was fitted to the gap went";
  std::string separator;
  for (const auto& [joint, initial] : judge.at("initial").items()) {
    text +=
        fmt::format("{} from {} to {}", separator, degreesCell(initial), errorText(judge.at("final").at(joint), joint));
    separator = ",";
  }
  return text + (held_out ? "." : "; only poses it has not seen (--validation) can show what that is worth.");
}

/// Validation first, its worst pose first: what a reader wants to see.
void addPoses(const ResultFiles& files, Page& page) {
  const PoseErrorTables errors(files.table("errors.csv"), {"before", "after"}, "");
  if (auto scene = armScene(files, errors.scenePoses())) page.add(std::move(*scene));
  std::vector<std::string> sets = errors.sets();
  std::ranges::reverse(sets);
  for (const std::string& set : sets) page.add(errors.chart(set));
}

void addConvergence(const ResultFiles& files, Page& page) {
  const Json& result = files.result();
  page.addSection("Convergence");
  const bool strategy = result.at("optimizer") == "es";
  const CsvTable history = files.table("history.csv");
  const std::vector<double> steps = numbersOf(history, "generation");
  const std::vector<double> course = numbersOf(history, "best_so_far_rad2");
  if (!strategy && !course.empty() && std::ranges::min(course) > 0.99 * std::ranges::max(course)) {
    page.add(PageText{fmt::format("None of the {} descents came much lower than the first: there is no course to draw.",
                                  course.size())});
    return;
  }
  const Axis x{strategy || result.at("optimizer") == "cma-es" ? "generation" : "descent"};
  std::vector<Series> mje;
  for (const std::string& column : history.columns()) {
    const std::size_t end = column.rfind('_');
    if (!column.starts_with("mje_") || end < 4) continue;
    const std::string joint = column.substr(4, end - 4);
    mje.push_back({column.ends_with("_mm") ? joint + " [mm]" : joint, steps, numbersOf(history, column)});
  }
  if (result.contains("capture_sd_deg")) {
    const std::vector<double> noise(steps.size(), numberOf(result.at("capture_sd_deg")));
    mje.push_back({"capture noise", steps, noise, Series::Style::kDashed, 6});
  }
  page.add(lineChart("Mean joint error of the best model so far", x, {"mean joint error [deg]", true}, mje));
  page.add(
      lineChart("Fitness", x, {"sum of squared errors [rad²]", true},
                {{"best of all", steps, numbersOf(history, "best_so_far_rad2")},
                 {strategy ? "best of the generation" : "best of the step", steps, numbersOf(history, "best_rad2")},
                 {"median", steps, numbersOf(history, "median_rad2")}}));
  if (!strategy) return;
  page.add(lineChart("Step sizes, relative to the initial ones", x, {"step size / initial", true},
                     {{"largest", steps, numbersOf(history, "sigma_max")},
                      {"median", steps, numbersOf(history, "sigma_median")},
                      {"smallest", steps, numbersOf(history, "sigma_min")}}));
}

/// How far a parameter has moved, in standard deviations of the hand measurement.
IntervalRow moved(const Json& parameter) {
  const double prior = numberOf(parameter.value("prior_sd", Json(nullptr)));
  const double sd = numberOf(parameter.at("sd")) / prior;
  const double way = (numberOf(parameter.at("value")) - numberOf(parameter.at("initial"))) / prior;
  IntervalRow row{parameter.at("name"), way, way - sd, way + sd};
  if (parameter.at("identifiable").is_string()) row.group = parameter.at("identifiable");
  row.colour = row.group == "not identifiable" ? 6 : row.group == "weak" ? 1 : 0;
  row.marked = parameter.at("at_bound");
  return row;
}

void addMoved(const Json& result, Page& page) {
  constexpr std::size_t kMost = 30;
  std::vector<IntervalRow> rows;
  for (const Json& parameter : result.at("parameters")) {
    const IntervalRow row = moved(parameter);
    if (std::isfinite(row.value)) rows.push_back(row);
  }
  std::ranges::stable_sort(rows, std::greater(), [](const IntervalRow& row) { return std::abs(row.value); });
  if (rows.empty()) return;
  const std::size_t count = rows.size();
  rows.resize(std::min(count, kMost));
  Chart chart = intervalChart("Parameters moved most", {"change / prior standard deviation"}, rows);
  chart.note = fmt::format(
      "{} of {}, with one standard deviation of what is known now; colour: what the poses tell of it; a triangle "
      "stands at its bound.",
      rows.size(), count);
  chart.wide = true;
  page.add(std::move(chart));
}

Table parameterTable(const Json& result) {
  Table table{"All parameters",
              {"name", "unit", "initial", "calibrated", "change", "sd before", "sd after", "the poses", "at bound"},
              {},
              true};
  for (const Json& p : result.at("parameters")) {
    table.rows.push_back({p.at("name"), p.at("unit"), numberText(p.at("initial"), "{:.6g}"),
                          numberText(p.at("value"), "{:.6g}"),
                          fmt::format("{:+.3g}", numberOf(p.at("value")) - numberOf(p.at("initial"))),
                          numberText(p.value("prior_sd", Json(nullptr)), "{:.2g}"), numberText(p.at("sd"), "{:.2g}"),
                          p.at("identifiable").is_string() ? p.at("identifiable").get<std::string>() : "",
                          p.at("at_bound").get<bool>() ? "yes" : ""});
  }
  return table;
}

void addParameters(const ResultFiles& files, Page& page) {
  const Json& result = files.result();
  page.addSection("Parameters");
  addMoved(result, page);
  if (files.has("singular_values.csv")) {
    const CsvTable values = files.table("singular_values.csv");
    const std::vector<double> direction = numbersOf(values, "direction");
    Chart chart = lineChart("What the poses tell", {"direction"}, {"singular value", true},
                            {{"singular value", direction, numbersOf(values, "singular_value")},
                             {"as much as the hand measurement", direction, std::vector<double>(direction.size(), 1.0),
                              Series::Style::kDashed, 6}});
    chart.note = "Directions above 1 are known better from the poses than from the hand measurements.";
    page.add(std::move(chart));
  }
  if (result.contains("identifiability")) {
    Table told{"What the poses tell of the parameters", {"verdict", "parameters"}, {}};
    for (const auto& [verdict, count] : result.at("identifiability").items()) {
      told.rows.push_back({verdict, std::to_string(wholeNumber(count))});
    }
    page.add(std::move(told));
  }
  const Json combinations = result.value("combinations", Json::array());
  if (!combinations.empty()) {
    Table known{"Known only together", {"parameters"}, {}, combinations.size() > 8};
    for (const Json& combination : combinations) known.rows.push_back({combination.at("text")});
    page.add(std::move(known));
  }
  page.add(parameterTable(result));
}

/// What the calibrated model is worth on the poses that judge it, and what goes on from it.
PageVerdict verdictOf(const ResultFiles& files) {
  using enum PageVerdict::Level;
  const Json& result = files.result();
  const bool held_out = result.at("mje_deg").contains("validation");
  const char* set = held_out ? "validation" : "calibration";
  const std::string model = files.path("model.yaml"), poses = files.input("poses", "POSES.csv");
  const std::string again = fmt::format("simgap calibrate {} --poses {}{}", files.input("model", "MODEL.yaml"), poses,
                                        held_out ? " --validation " + files.input("validation", "OTHER.csv") : "");
  if (const auto failure = result.find("failure"); failure != result.end() && failure->is_string()) {
    const bool kept = result.value("delivered", std::string()) == "start";
    return {kBad, kept ? "worse than the start" : "not valid", failure->get<std::string>(), again};
  }
  const Json counts = result.at("valid_poses").at(set);
  const long of = wholeNumber(counts.at("of"));
  const long valid = counts.contains("final") ? wholeNumber(counts.at("final")) : of;
  if (valid < of) {
    return {kDoubtful, fmt::format("{} of {} poses valid", valid, of),
            "The means leave out the poses in which the arm does not come to rest.",
            fmt::format("simgap validate {} --poses {} --evaluator equilibrium", model, poses)};
  }
  if (const std::string doubt = notConverged(result); !doubt.empty()) return {kDoubtful, "not converged", doubt, again};
  if (!surprises(result).empty()) {
    return {kDoubtful, "missed by more than expected", "Poses are missed by more than the model's own uncertainty.",
            fmt::format("simgap diagnose {} --poses {}", model, poses)};
  }
  if (!held_out) {
    return {kDoubtful, "not judged", "Only poses it was not fitted to can show what it is worth.",
            fmt::format("simgap validate {} --poses OTHER_POSES.csv", model)};
  }
  return {kGood, "good", "It holds on poses the search never saw.",
          fmt::format("simgap design {} --poses {}", files.input("model", "MODEL.yaml"), poses)};
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  std::vector<std::string> notes = surprises(result);
  if (const std::string doubt = notConverged(result); !doubt.empty()) notes.insert(notes.begin(), doubt);
  Page page{"simgap calibrate", answer(result), notes};
  page.verdict = verdictOf(files);
  addPoses(files, page);
  page.addSection("How large the gap is");
  page.add(calibrationErrors(result));
  if (result.contains("predicted_mje_deg")) page.add(predictionTable(result));
  if (result.contains("verification")) page.add(verificationTable(result));
  addConvergence(files, page);
  addParameters(files, page);
  page.addSection("Poses");
  page.add(PoseErrorTables(files.table("errors.csv"), {"before", "after"}, "").table(/*folded=*/true));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/calibrate/1", make};

}  // namespace simgap::pages::calibrate
