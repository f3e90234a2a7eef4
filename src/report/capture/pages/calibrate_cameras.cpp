#include <fmt/format.h>

#include "report/capture/capture_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::calibrate_cameras {
namespace {

Chart viewErrors(const Json& result) {
  std::vector<std::string> names;
  std::vector<double> errors;
  for (const Json& view : result.at("views")) {
    names.push_back(view.at("name"));
    errors.push_back(numberOf(view.at("rms_px")));
  }
  Chart chart =
      barChart("Reprojection error of each view", names, {"error [px]"}, {{"root mean square error", {}, errors}});
  chart.note = "A gap: the view was left out.";
  chart.wide = true;
  return chart;
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap calibrate-cameras", cameraAnswer(result), {}};
  if (result.at("scale_bar").is_null()) {
    page.notes.emplace_back("Without a scale bar nothing but the board's own size says how long a metre is.");
  }
  constexpr double kLargestError = 1.0;  // px
  const bool good = numberOf(result.at("heldout_rms_px")) < kLargestError;
  page.verdict = {good ? PageVerdict::Level::kGood : PageVerdict::Level::kBad, good ? "good" : "large errors",
                  good ? "Views that were held out are met within a pixel."
                       : "A wrong spacing or number of corners, or views that are not of one moment.",
                  "simgap capture RIG.yaml --left LEFT --right RIGHT"};
  page.add(viewErrors(result));
  page.addSection("Numbers");
  page.add(cameraFigures(result));
  page.add(cameraParameters(result));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/calibrate-cameras/1", make};

}  // namespace simgap::pages::calibrate_cameras
