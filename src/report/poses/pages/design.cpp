#include <fmt/format.h>

#include "report/poses/pose_page.h"
#include "report/poses/pose_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::design {
namespace {

std::string answer(const Json& result) {
  const Json predicted = ofAllJoints(result, "predicted_mje");
  std::string text =
      fmt::format("Recording {} more poses is expected to bring the error on unseen poses", result.at("poses").size());
  std::string separator;
  for (const auto& [joint, before] : predicted.at("before").items()) {
    text += fmt::format("{} from {} to {}", separator, degreesCell(before.at("mean")),
                        errorText(predicted.at("after").at(joint).at("mean"), joint));
    separator = ",";
  }
  return text + ".";
}

Chart expectedChart(const Json& result) {
  const Json predicted = ofAllJoints(result, "predicted_mje");
  std::vector<Series> lines;
  for (const auto& [joint, before] : predicted.at("before").items()) {
    Series line{joint, {0.0}, {numberOf(before.at("mean"))}};
    Series random{
        joint + ", random commands instead", {}, {}, Series::Style::kPoints, static_cast<int>(lines.size() / 2)};
    line.colour = random.colour;
    for (const Json& pose : result.at("poses")) {
      line.x.push_back(static_cast<double>(line.x.size()));
      line.y.push_back(numberOf(ofAllJoints(pose, "predicted_mje").at(joint).at("mean")));
    }
    random.x = {line.x.back()};
    random.y = {numberOf(predicted.at("after_random").at(joint).at("mean"))};
    lines.push_back(line);
    lines.push_back(random);
  }
  Chart chart = lineChart("Expected mean joint error with the first poses of the list recorded", {"poses added"},
                          {"mean joint error [deg]"}, lines);
  chart.wide = true;
  return chart;
}

Table commands(const Json& result) {
  Table table{"Commands [rad]; next_poses.csv holds them for the rig", {"pose"}, {}};
  for (const Json& pose : result.at("poses")) {
    std::vector<std::string> row{pose.at("pose")};
    for (const auto& [muscle, shaft] : pose.at("shaft_rad").items()) {
      if (table.rows.empty()) table.header.push_back(muscle);
      row.push_back(fmt::format("{:.3f}", numberOf(shaft)));
    }
    table.rows.push_back(row);
  }
  return table;
}

Page make(const ResultFiles& files) {
  Page page{"simgap design", answer(files.result()), {}};
  page.verdict = {PageVerdict::Level::kGood, "done",
                  "Record these commands, add them to the poses, and calibrate again.",
                  fmt::format("simgap calibrate {} --poses ALL_POSES.csv", files.input("model", "MODEL.yaml"))};
  std::vector<ScenePose> scene_poses;
  for (const Json& pose : files.result().at("poses"))
    scene_poses.push_back({"next", pose.at("pose"), {{"expected", "expected by the fitted model"}}});
  if (auto scene = armScene(files, scene_poses)) {
    scene->scene["ghost"] = nullptr;
    scene->note =
        "Where the fitted model expects the arm. Drag or use the arrow keys to turn; click, then scroll to come "
        "nearer.";
    scene->scene["slider"] = "pose, the most telling first";
    page.add(std::move(*scene));
  }
  page.add(expectedChart(files.result()));
  page.add(expectedErrors(files.result()));
  page.addSection("What to record");
  page.add(commands(files.result()));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/design/1", make};

}  // namespace simgap::pages::design
