#include <fmt/format.h>

#include <algorithm>

#include "report/capture/capture_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::calibrate_joints {
namespace {

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  std::vector<std::string> names;
  std::vector<double> residual, centre;
  for (const Json& j : result.at("joints")) {
    names.push_back(j.at("name"));
    residual.push_back(numberOf(j.at("residual_mm")));
    centre.push_back(numberOf(j.at("centre_sd_mm")));
  }
  Page page{"simgap calibrate-joints", jointAnswer(result), {}};
  constexpr double kLargestSd = 1.0;  // mm
  const bool good = std::ranges::all_of(centre, [](double sd) { return sd < kLargestSd; });
  page.verdict = {
      good ? PageVerdict::Level::kGood : PageVerdict::Level::kDoubtful, good ? "good" : "hardly known",
      good ? "Every centre is known within a millimetre." : "A motion that turns every joint further tells more.",
      fmt::format("simgap capture {} --left LEFT --right RIGHT", files.path("rig.yaml"))};
  page.add(barChart("How well each joint is known", names, {"[mm]"},
                    {{"residual of a frame", {}, residual}, {"standard deviation of the centre", {}, centre}}));
  page.add(jointTable(result));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/calibrate-joints/1", make};

}  // namespace simgap::pages::calibrate_joints
