#include <fmt/format.h>

#include "report/motions/motion_tables.h"
#include "report/poses/pose_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::validate_motions {
namespace {

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  std::string answer = fmt::format("Over {} motions the simulation misses the robot by", result.at("motions").size());
  const char* separator = "";
  for (const auto& [channel, rms] : result.at("motion_rms").items()) {
    answer += fmt::format("{} {} ({}; noise {})", separator, numberText(rms, "{:.3f}"), channel,
                          numberText(result.at("noise").at(channel), "{:.3f}"));
    separator = ",";
  }
  Page page{"simgap validate", answer + " root mean square.", {}};
  bool failed = false;
  for (const Json& criterion : result.at("criteria")) failed = failed || !criterion.at("pass").get<bool>();
  const std::string next = fmt::format("simgap calibrate {} --motions {}", files.input("model", "MODEL.yaml"),
                                       files.input("motions", "MOTIONS.yaml"));
  page.verdict = failed ? PageVerdict{PageVerdict::Level::kBad, "fails the limit", "", next}
                        : PageVerdict{PageVerdict::Level::kGood, "played", "", next};
  page.add(validationRms(result));
  page.add(worstChannels(result));
  if (!result.at("criteria").empty()) page.add(criteriaTable(result));
  page.addSection("Errors over time");
  addResidualCharts(files, page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/validate-motions/1", make};

}  // namespace simgap::pages::validate_motions
