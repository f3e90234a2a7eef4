#include <fmt/format.h>

#include <cmath>

#include "simgap/report/html/result_page.h"

namespace simgap::pages {
namespace {

/// "1.23", with a "!" when noise could bridge it.
std::string millimetres(const Json& likeness) {
  const double rms = numberOf(likeness.at("rms_mm"));
  return (std::isfinite(rms) ? fmt::format("{:.2f}", rms) : "-") + (likeness.at("confused").get<bool>() ? " !" : "");
}

std::string markers(const Json& list) {
  std::string text;
  for (const Json& marker : list) text += (text.empty() ? "" : " ") + marker.dump();
  return text;
}

PageTable targetTable(const Json& result) {
  PageTable table{"Each target [mm]",
                  {"target", "smallest gap", "from its plane", "other order", "mirror image", "3 markers for 3 others"},
                  {}};
  for (const Json& t : result.at("targets")) {
    table.rows.push_back({t.at("name"), fmt::format("{:.2f}", numberOf(t.at("smallest_gap_mm"))),
                          fmt::format("{:.2f}", numberOf(t.at("from_plane_mm"))), millimetres(t.at("symmetry")),
                          millimetres(t.at("mirror")), millimetres(t.at("triple"))});
  }
  return table;
}

PageTable crossTable(const Json& result) {
  PageTable table{"Targets against each other [mm]", {"taken for one another", "whole", "3 markers", "these 3"}, {}};
  for (std::size_t i = 0; i < result.at("cross").size(); ++i) {
    const Json& triple = result.at("cross_triples").at(i);
    table.rows.push_back({triple.at("from").get<std::string>() + " / " + triple.at("to").get<std::string>(),
                          millimetres(result.at("cross").at(i)), millimetres(triple),
                          markers(triple.at("markers")) + " / " + markers(triple.at("taken_for"))});
  }
  return table;
}

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
  Page page{
      "simgap targets check",
      fmt::format("{} at a noise of {:.2f} mm per marker.",
                  result.at("sound").get<bool>() ? "Whole targets cannot be confused" : "Whole targets CAN be confused",
                  numberOf(result.at("noise_mm"))),
      {}};
  page.add(gaps(result));
  page.addSection("Numbers");
  page.add(targetTable(result));
  page.add(crossTable(result));
  return page;
}

}  // namespace

extern const ResultPage targets_check;
const ResultPage targets_check{"simgap/targets-check/1", make};

}  // namespace simgap::pages
