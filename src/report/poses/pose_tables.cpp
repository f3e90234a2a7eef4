#include "pose_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "simgap/core/joint_kind.h"
#include "simgap/core/json_numbers.h"

namespace simgap {

namespace {

constexpr std::string_view kSlideLabel = " [mm]";

/// Numbers of joints that slide, under their labels. A joint holds a number or what was predicted of it.
void addSlides(const Json& slides, Json& all) {
  for (const auto& [key, value] : slides.items()) {
    if (value.is_object() && !value.contains("ci90")) {
      addSlides(value, all[key]);
    } else {
      all[key + std::string(kSlideLabel)] = value;
    }
  }
}

}  // namespace

std::vector<std::string> errorUnits(const PoseLayout& layout) {
  std::vector<std::string> units{"deg"};
  for (const JointChannel& joint : layout.joints) {
    const std::string unit(kindOf(joint.type).error_unit);
    if (std::ranges::find(units, unit) == units.end()) units.push_back(unit);
  }
  return units;
}

Json mjeJson(const PoseLayout& layout, const std::vector<double>& mje, const std::string& unit) {
  Json json = Json::object();
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const JointKind& kind = kindOf(layout.joints[j].type);
    if (kind.error_unit == unit) json[layout.joints[j].name] = numberOrNull(kind.shown(mje[j]));
  }
  return json;
}

Json predictionJson(const PoseLayout& layout, const PredictedError& predicted, const std::string& unit) {
  Json json = Json::object();
  for (std::size_t j = 0; j < predicted.mean.size(); ++j) {
    const JointKind& kind = kindOf(layout.joints[j].type);
    if (kind.error_unit != unit) continue;
    json[layout.joints[j].name] = {{"mean", kind.shown(predicted.mean[j])},
                                   {"ci90", {kind.shown(predicted.lower[j]), kind.shown(predicted.upper[j])}}};
  }
  return json;
}

Json ofAllJoints(const Json& result, const std::string& name) {
  Json all = result.at(name + "_deg");
  if (const auto slides = result.find(name + "_mm"); slides != result.end()) addSlides(*slides, all);
  return all;
}

std::string jointLabel(const JointChannel& joint) {
  return kindOf(joint.type).slides ? joint.name + std::string(kSlideLabel) : joint.name;
}

std::string errorText(const Json& error, const std::string& label) {
  if (!label.ends_with(kSlideLabel)) return fmt::format("{}° ({})", degreesCell(error), label);
  return fmt::format("{} mm ({})", degreesCell(error), label.substr(0, label.size() - kSlideLabel.size()));
}

std::vector<double> paperAngles(const PoseLayout& layout, std::vector<double> angles) {
  for (std::size_t j = 0; j < angles.size(); ++j) {
    angles[j] *= kindOf(layout.joints[j].type).printed_error;
  }
  return angles;
}

std::vector<std::string> slackMuscles(const PoseOutcome& outcome, const PoseLayout& layout) {
  std::vector<std::string> slack;
  for (std::size_t m = 0; m < outcome.cord_expansion.size(); ++m) {
    if (outcome.cord_expansion[m] <= 0.0) slack.push_back(layout.muscles[m]);
  }
  return slack;
}

std::string slackText(const PoseOutcome& outcome, const PoseLayout& layout) {
  return fmt::format("{}", fmt::join(slackMuscles(outcome, layout), " "));
}

std::vector<std::string> invalidPoses(const Assessment& assessment, const PoseSet& set, const PoseLayout& layout) {
  std::vector<std::string> lines;
  for (std::size_t p = 0; p < set.poses.size(); ++p) {
    if (assessment.outcomes[p].status == PoseStatus::kSteady) continue;
    lines.push_back(fmt::format("{}: {}", set.poses[p].name, describe(assessment.outcomes[p], layout)));
  }
  return lines;
}

namespace {

constexpr const char* kPaperAngles = "  as half angles (paper)";
constexpr const char* kPosesAtRest = "  at rest";

/// Errors per joint, two decimals.
std::vector<std::string> errorRow(std::string name, const Json& joints) {
  std::vector<std::string> row{std::move(name)};
  for (const auto& [joint, degrees] : joints.items()) row.push_back(degreesCell(degrees));
  return row;
}

std::vector<std::string> errorRow(std::string name, const Json& before, const Json& after) {
  std::vector<std::string> row{std::move(name)};
  for (const auto& [joint, degrees] : after.items()) {
    row.insert(row.end(), {degreesCell(before.at(joint)), degreesCell(degrees)});
  }
  return row;
}

/// "1.30 (0.90 to 1.80)"
std::string interval(const Json& expected) {
  return fmt::format("{} ({} to {})", degreesCell(expected.at("mean")), degreesCell(expected.at("ci90").at(0)),
                     degreesCell(expected.at("ci90").at(1)));
}

}  // namespace

Table calibrationErrors(const Json& result) {
  const Json sets = ofAllJoints(result, "mje"), paper = ofAllJoints(result, "paper_mje");
  Table table{"Mean joint errors [deg]", {"mean joint error [deg]"}, {}};
  for (const auto& [joint, degrees] : sets.at("calibration").at("final").items()) {
    table.header.insert(table.header.end(), {joint + " before", "after"});
  }
  for (const auto& [set, errors] : sets.items()) {
    const Json& poses = result.at("valid_poses").at(set);
    table.rows.push_back(errorRow(
        fmt::format("{} ({} of {} poses)", set, wholeNumber(poses.at("compared")), wholeNumber(poses.at("of"))),
        errors.at("initial"), errors.at("final")));
    // Halved angles are another thing only where there is a spherical joint.
    if (paper.at(set) != errors) {
      table.rows.push_back(errorRow(kPaperAngles, paper.at(set).at("initial"), paper.at(set).at("final")));
    }
    if (poses.at("initial") == poses.at("of") && poses.at("final") == poses.at("of")) continue;
    table.rows.push_back({kPosesAtRest});
    for (std::size_t j = 0; j < errors.at("final").size(); ++j) {
      for (const char* when : {"initial", "final"}) {
        table.rows.back().push_back(fmt::format("{} of {}", wholeNumber(poses.at(when)), wholeNumber(poses.at("of"))));
      }
    }
  }
  return table;
}

Table validationErrors(const Json& result) {
  Table table{"Mean joint errors [deg]", {""}, {}};
  const Json mje = ofAllJoints(result, "mje"), paper = ofAllJoints(result, "paper_mje");
  for (const auto& [joint, degrees] : mje.items()) table.header.push_back(joint);
  const long valid = wholeNumber(result.at("valid_poses"));
  table.rows = {errorRow(fmt::format("mean joint error [deg], {} of {} poses", valid, result.at("poses").size()), mje)};
  if (paper != mje) table.rows.push_back(errorRow(kPaperAngles, paper));
  return table;
}

Table criteriaTable(const Json& result) {
  Table table{"Criteria", {"criterion", "limit", "found", "verdict"}, {}};
  for (const Json& c : result.at("criteria")) {
    table.rows.push_back({c.at("name"), fmt::format("{:g}", c.at("limit").get<double>()), degreesCell(c.at("value")),
                          c.at("pass").get<bool>() ? "pass" : "FAIL"});
  }
  return table;
}

Table expectedErrors(const Json& result) {
  const Json predicted = ofAllJoints(result, "predicted_mje");
  Table table{"Predicted mean joint error of unseen poses, with a 90 % interval [deg]", {"recorded"}, {}};
  const auto add = [&](std::string name, const Json& joints) {
    std::vector<std::string> row{std::move(name)};
    for (const auto& [joint, expected] : joints.items()) row.push_back(interval(expected));
    table.rows.push_back(row);
  };
  for (const auto& [joint, before] : predicted.at("before").items()) table.header.push_back(joint);
  add(fmt::format("the {} poses so far", wholeNumber(result.at("recorded"))), predicted.at("before"));
  for (const Json& pose : result.at("poses")) {
    add("and " + pose.at("pose").get<std::string>(), ofAllJoints(pose, "predicted_mje"));
  }
  add(fmt::format("{} random commands instead", result.at("poses").size()), predicted.at("after_random"));
  return table;
}

Table predictionTable(const Json& result) {
  Table table{"Mean joint error that the posterior predicts, with a 90 % interval [deg]", {"poses"}, {}};
  const bool judged = result.contains("mje_deg");  // a plan has found nothing yet
  const Json mje = judged ? ofAllJoints(result, "mje") : Json::object();
  const Json predicted = ofAllJoints(result, "predicted_mje");
  for (const auto& [set, joints] : predicted.items()) {
    std::vector<std::string> row{set};
    const bool first = table.header.size() == 1;
    for (const auto& [joint, expected] : joints.items()) {
      if (first) table.header.push_back(joint + " predicted");
      row.push_back(interval(expected));
      if (!judged) continue;
      if (first) table.header.push_back("found");
      const Json found = mje.value(set, Json(nullptr));
      row.push_back(found.is_null() ? "" : degreesCell(found.at("final").at(joint)));
    }
    table.rows.push_back(row);
  }
  return table;
}

Table verificationTable(const Json& result) {
  const Json& both = result.at("verification");
  const std::string searcher = both.at("searched_by"), judge = both.at("judge");
  Table table{fmt::format("Mean joint error that {} finds, and how far {} differs from it [deg]", searcher, judge),
              {"poses"},
              {}};
  for (const auto& [set, found] : both.at("sets").items()) {
    std::vector<std::string> row{set};
    const Json mje = ofAllJoints(found, "mje"), difference = ofAllJoints(found, "difference");
    for (const auto& [joint, mean] : difference.at("mean").items()) {
      if (table.rows.empty()) table.header.insert(table.header.end(), {joint, "differs", "at most"});
      row.insert(row.end(),
                 {degreesCell(mje.at(joint)), degreesCell(mean), degreesCell(difference.at("largest").at(joint))});
    }
    table.rows.push_back(row);
  }
  return table;
}

std::string notConverged(const Json& result) {
  if (!result.contains("sd_from_optimum") || result.at("sd_from_optimum").is_null()) return {};
  if (result.at("converged").get<bool>()) return {};
  const bool descent = result.at("optimizer") == "lm" || result.at("optimizer") == "hybrid";
  return fmt::format(
      "Not converged: the parameters are {:.2g} standard deviations from the most probable ones, so nothing can be "
      "said "
      "of how well they are known; try {}.",
      result.at("sd_from_optimum").get<double>(), descent ? "more --starts" : "--optimizer lm");
}

namespace {

/// Whether two simulations of one model differ by more than what the model is blamed for: then it is not the model.
bool restsElsewhere(const Json& result, const std::string& set, const std::string& joint, double beyond) {
  if (!result.contains("verification")) return false;
  const Json& sets = result.at("verification").at("sets");
  return sets.contains(set) && numberOf(ofAllJoints(sets.at(set), "difference").at("mean").at(joint)) > beyond;
}

}  // namespace

std::vector<std::string> surprises(const Json& result) {
  constexpr std::size_t kMostNamed = 8;
  std::vector<std::string> notes;
  const Json mje = ofAllJoints(result, "mje");
  const Json predicted =
      result.contains("predicted_mje_deg") ? ofAllJoints(result, "predicted_mje") : Json(Json::object());
  for (const auto& [set, sides] : mje.items()) {
    const Json expected_of_set = predicted.value(set, Json::object());
    for (const auto& [joint, expected] : expected_of_set.items()) {
      const double found = numberOf(sides.at("final").at(joint)), upper = numberOf(expected.at("ci90").at(1));
      if (!(found > upper)) continue;
      const bool slides = joint.ends_with(kSlideLabel);
      notes.push_back(fmt::format(
          "On the {0} poses the {1} misses by {2:.2f}{4} where at most {3:.2f}{4} was to be expected: {5}.", set,
          slides ? joint.substr(0, joint.size() - kSlideLabel.size()) : joint, found, upper, slides ? " mm" : "°",
          restsElsewhere(result, set, joint, found - upper)
              ? fmt::format("{} comes to rest elsewhere with the same model than {}, by more than that (several rests "
                            "at a command, or friction on the way), so they tell nothing of what the model lacks",
                            result.at("verification").at("judge").get<std::string>(),
                            result.at("verification").at("searched_by").get<std::string>())
              : "something is not in the model"));
    }
  }
  const Json outlying = result.value("outlying_poses", Json::array());
  if (outlying.size() > kMostNamed) notes.push_back(fmt::format("{} poses lie far from the fit.", outlying.size()));
  if (!outlying.empty() && outlying.size() <= kMostNamed) {
    std::string names;
    for (const Json& pose : outlying) {
      names += fmt::format("{}{} ({:.1f} sd)", names.empty() ? "" : ", ", pose.at("pose").get<std::string>(),
                           pose.at("distance_sd").get<double>());
    }
    notes.push_back("Poses far from the fit, hardly counted: " + names + ".");
  }
  return notes;
}

}  // namespace simgap
