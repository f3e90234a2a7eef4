#include <fmt/format.h>

#include "simgap/report/html/result_page.h"

namespace simgap::pages {
namespace {

PageTable figures(const Json& result) {
  const Json& coverage = result.at("coverage");
  PageTable table{"Figures", {"figure", "value"}, {}};
  table.rows = {
      {"pairs looked at, with the board, left out",
       fmt::format("{}, {}, {}", result.at("pairs").dump(), result.at("views").size(), result.at("outliers").dump())},
      {"reprojection error, views used [px]", fmt::format("{:.4f}", numberOf(result.at("rms_px")))},
      {"reprojection error, views held out [px]", fmt::format("{:.4f}", numberOf(result.at("heldout_rms_px")))},
      {"image covered by corners, left and right [%]",
       fmt::format("{:.0f}, {:.0f}", 100.0 * numberOf(coverage.at("left")), 100.0 * numberOf(coverage.at("right")))}};
  const Json& bar = result.at("scale_bar");
  table.rows.push_back({"scale bar, measured and nominal [mm]",
                        bar.is_null()
                            ? "none: the scale is that of the board"
                            : fmt::format("{:.4f} ± {:.4f}, {:.4f} ({:+.3f} %)", numberOf(bar.at("measured_mm")),
                                          numberOf(bar.at("sd_mm")), numberOf(bar.at("nominal_mm")),
                                          numberOf(bar.at("error_percent")))});
  return table;
}

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
  const Json& baseline = result.at("parameters").back();
  Page page{"simgap calibrate-cameras",
            fmt::format("Views that were held out are met within {:.3f} px ({:.3f} px on the views used); baseline "
                        "{:.3f} mm ± {:.3f}.",
                        numberOf(result.at("heldout_rms_px")), numberOf(result.at("rms_px")),
                        numberOf(baseline.at("value")), numberOf(baseline.at("sd"))),
            {}};
  if (result.at("scale_bar").is_null()) {
    page.notes.emplace_back("Without a scale bar nothing but the board's own size says how long a metre is.");
  }
  page.add(viewErrors(result));
  page.addSection("Numbers");
  page.add(figures(result));
  PageTable parameters{"Parameters (sd: jackknife over the held-out groups)", {"parameter", "value", "sd", "unit"}, {}};
  for (const Json& p : result.at("parameters")) {
    parameters.rows.push_back({p.at("name"), fmt::format("{:.5g}", numberOf(p.at("value"))),
                               fmt::format("{:.2g}", numberOf(p.at("sd"))), p.at("unit")});
  }
  page.add(std::move(parameters));
  return page;
}

}  // namespace

extern const ResultPage calibrate_cameras;
const ResultPage calibrate_cameras{"simgap/calibrate-cameras/1", make};

}  // namespace simgap::pages
