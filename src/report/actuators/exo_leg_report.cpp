#include "simgap/report/actuators/exo_leg_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"

namespace simgap {
namespace {

std::string shareText(const Json& share) { return numberText(Json(100.0 * numberOf(share)), "{:.1f} %"); }

}  // namespace

Json toJson(const ExoLeg& leg, const ExoLegStudy& study) {
  Json runs = Json::array();
  for (const ExoLegRun& run : study.runs) {
    runs.push_back({{"name", run.name},
                    {"standing_share", run.standing},
                    {"obeyed_share", run.obeyed},
                    {"at_limit_share", run.at_limit},
                    {"ankle_largest_Nm", run.largest[0]},
                    {"knee_largest_Nm", run.largest[1]}});
  }
  return {{"format", "simgap/simulate-leg/1"},
          {"leg", leg.name},
          {"start_s", study.start},
          {"end_s", study.end},
          {"step_s", study.step},
          {"controller_rate_Hz", leg.rate},
          {"assist_share", leg.assist.share},
          {"half_step_mm", 1e3 * study.half_step},
          {"runs", runs},
          {"notes", study.notes}};
}

std::string exoLegAnswer(const Json& result) {
  const Json &assisted = result.at("runs").at(0), &alone = result.at("runs").at(1);
  return fmt::format(
      "{:.4g} s of {}: with {} of the weight borne by the exoskeleton the hip is where it was told to be, high or low, "
      "in "
      "{} of the time, without it in {}",
      numberOf(result.at("end_s")) - numberOf(result.at("start_s")), result.at("leg").get<std::string>(),
      numberText(Json(100.0 * numberOf(result.at("assist_share"))), "{:.0f} %"), shareText(assisted.at("obeyed_share")),
      shareText(alone.at("obeyed_share")));
}

Table exoLegTable(const Json& result) {
  Table table{"Standing up", {"leg", "as told", "stands if told", "ankle [Nm]", "knee [Nm]", "at a limit"}, {}};
  for (const Json& run : result.at("runs")) {
    table.rows.push_back({run.at("name").get<std::string>(), shareText(run.at("obeyed_share")),
                          shareText(run.at("standing_share")), numberText(run.at("ankle_largest_Nm"), "{:.1f}"),
                          numberText(run.at("knee_largest_Nm"), "{:.1f}"), shareText(run.at("at_limit_share"))});
  }
  return table;
}

std::string exoLegText(const Json& result) { return answerText(exoLegAnswer(result), {exoLegTable(result)}); }

void writeExoLeg(const ExoLeg& leg, const ExoLegStudy& study, double rate, const RunDirectory& directory) {
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(leg.rate / rate)));
  CsvWriter csv({"time_s", "told_up", "ankle_rad", "knee_rad", "hip_height_m", "hip_height_alone_m", "ankle_assist_Nm",
                 "knee_assist_Nm", "leaning_N"});
  const ExoLegTrack& t = study.runs[0].track;
  for (std::size_t i = 0; i < t.time.size(); i += stride) {
    csv.add(t.time[i]).add(t.up[i] ? 1.0 : 0.0).add(t.ankle[i]).add(t.knee[i]);
    csv.add(t.hip[i]).add(study.runs[1].track.hip[i]);
    csv.add(t.ankle_assist[i]).add(t.knee_assist[i]).add(t.leaning[i]).endRow();
  }
  directory.write("motion.csv", csv.text());
}

}  // namespace simgap
