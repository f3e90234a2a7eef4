#include "report/capture/capture_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::targets_check {
namespace {

/// What noise must bridge before a target is taken for something else.
Chart gaps(const Json& result) {
  std::vector<std::string> names;
  Series order{"other order of its markers", {}, {}}, mirror{"its mirror image", {}, {}};
  Series triple{"3 markers for 3 others", {}, {}};
  for (const Json& t : result.at("targets")) {
    names.push_back(t.at("name"));
    order.y.push_back(numberOf(t.at("symmetry").at("rms_mm")));
    mirror.y.push_back(numberOf(t.at("mirror").at("rms_mm")));
    triple.y.push_back(numberOf(t.at("triple").at("rms_mm")));
  }
  return barChart("What noise must bridge to confuse a target", names, {"[mm]"}, {order, mirror, triple});
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap targets check", targetAnswer(result), {}};
  const bool sound = result.at("sound").get<bool>();
  page.verdict = {sound ? PageVerdict::Level::kGood : PageVerdict::Level::kBad, sound ? "good" : "can be confused",
                  sound ? "" : "Move the markers that are named below, by more than the noise bridges.",
                  sound ? "simgap capture RIG.yaml --left LEFT --right RIGHT" : ""};
  page.add(gaps(result));
  page.addSection("Numbers");
  page.add(targetTable(result));
  page.add(crossTable(result));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/targets-check/1", make};

}  // namespace simgap::pages::targets_check
