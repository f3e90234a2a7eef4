#include <algorithm>
#include <cmath>

#include "report/actuators/dynamics_tables.h"
#include "report/actuators/response_page.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::fit_dynamics {
namespace {

/// Errors of every joint, alone and with all others, side by side.
Chart errorChart(const Json& joints) {
  std::vector<std::string> names;
  Series alone{"each joint alone", {}, {}}, together{"all joints at once", {}, {}};
  for (const Json& joint : joints) {
    names.push_back(joint.at("name"));
    alone.y.push_back(100.0 * numberOf(joint.at("error_alone")));
    together.y.push_back(100.0 * numberOf(joint.at("error_heldout")));
  }
  Chart chart = barChart("Error on blocks held out", names, {"of the effort [%]"}, {alone, together});
  chart.wide = true;
  return chart;
}

PageVerdict verdictOf(const ResultFiles& files) {
  PageVerdict verdict{PageVerdict::Level::kGood, "good",
                      "The coupling of the joints explains what one joint could not.",
                      "simgap predict " + files.path("model.yaml") + " OTHER_LOG"};
  for (const Json& joint : files.result().at("joints")) {
    if (numberOf(joint.at("error_heldout")) < numberOf(joint.at("error_alone"))) continue;
    verdict.level = PageVerdict::Level::kDoubtful;
    verdict.words = "no gain";
    verdict.cause = "On rows held out the robot is no better for joint " + joint.at("name").get<std::string>() +
                    " than its own friction.";
  }
  if (!files.result().at("converged").get<bool>()) {
    verdict = {PageVerdict::Level::kBad, "not converged", "The search for bodies that can exist did not end.", ""};
  }
  return verdict;
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap fit-dynamics", dynamicsAnswer(result), result.at("warnings").get<std::vector<std::string>>()};
  page.verdict = verdictOf(files);
  page.add(errorChart(result.at("joints")));
  page.add(dynamicsJoints(result));
  page.addSection("Measured and predicted");
  addResponses(files.table("predictions.csv"), "_measured", "_predicted", page);
  page.addSection("The robot");
  page.add(dynamicsBodies(result));
  page.add(dynamicsDrives(result));
  page.add(dynamicsBase(result));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/fit-dynamics/1", make};

}  // namespace simgap::pages::fit_dynamics
